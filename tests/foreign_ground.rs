//! Elevation models of other programs, through the commands that read them.

use std::os::unix::fs::PermissionsExt as _;

use crate::harness::{Mission, json, stderr};
use crate::tiff_writer::{GeoTiff, Mask, Packing, Sample};
use serde_json::Value;

const SIDE: usize = 40;

/// Gentle ground with cells of 2 m, northernmost row first; the first rows hold `fill`.
fn heights(fill: Option<f64>) -> Vec<f64> {
    let height = |index: usize| match fill {
        Some(fill) if index < 6 * SIDE => fill,
        _ => 1200.0 + 2.0 * (index as f64 / 23.0).sin(),
    };
    (0..SIDE * SIDE).map(height).collect()
}

fn model(fill: Option<f64>) -> GeoTiff {
    GeoTiff { sample: Sample::F64, ..GeoTiff::new(SIDE, SIDE, heights(fill)) }
}

/// What a command says on both streams, having ended well.
fn told(mission: &Mission, words: &[&str]) -> String {
    let output = mission.hopper(words).output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 1)), "{words:?}: {}", stderr(&output));
    String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output)
}

fn checked(mission: &Mission, words: &[&str]) -> Value {
    let words = [&["scenario", "check", "--format", "json", "--dem", "dem.tif"], words].concat();
    json(&mission.hopper(&words).output().unwrap())
}

/// P-DEM-FILL. The same warning in every command, and `--nodata` settles it.
#[test]
fn every_command_warns_of_what_looks_like_nodata_until_it_is_settled() {
    let mission = Mission::new("fill");
    std::fs::write(mission.path("dem.tif"), model(Some(-9999.0)).bytes()).unwrap();
    let commands: [&[&str]; 4] = [
        &["terrain", "check", "dem.tif"],
        &["scenario", "check", "--dem", "dem.tif"],
        &["scenario", "new", "--dem", "dem.tif"],
        &["run", "--lockstep", "--dem", "dem.tif"],
    ];
    for words in commands {
        let warning = "-9999 looks like nodata that the file does not declare (240 cells hold it";
        assert!(told(&mission, words).contains(warning), "{words:?}");
        for settled in ["-9999", "none"] {
            let words = [words, &["--nodata", settled]].concat();
            if settled == "-9999" || words[0] != "run" {
                assert!(!told(&mission, &words).contains("looks like nodata"), "{words:?}");
            }
        }
    }
    let [suspected, settled, none] =
        [&[][..], &["--nodata", "-9999"], &["--nodata", "none"]].map(|words| checked(&mission, words));
    assert_eq!(suspected["findings"][0]["finding"], "suspected_nodata");
    assert_eq!(
        (&suspected["findings"][0]["value"], &suspected["findings"][0]["cells"]),
        (&(-9999.0).into(), &240.into())
    );
    assert_eq!(settled["findings"], Value::Array(vec![]));
    assert_eq!(suspected["hash"], settled["hash"], "it is the same ground");
    let datum_m = |check: &Value| check["brief"]["datum_m"].as_f64().unwrap();
    assert!((datum_m(&suspected) - 1200.0).abs() < 2.0 && datum_m(&none) < 0.0);
    let range = &suspected["brief"]["priors"]["height_m"];
    assert!(range["max"].as_f64().unwrap() - range["min"].as_f64().unwrap() < 5.0, "{range}");
    // A scenario keeps what was settled.
    let written =
        mission.hopper(&["scenario", "new", "--dem", "dem.tif", "--nodata", "-9999,7"]).output().unwrap();
    assert!(String::from_utf8_lossy(&written.stdout).contains("nodata = [-9999.0, 7.0]"));
    let refused =
        mission.hopper(&["run", "--lockstep", "--scenario", "hard", "--nodata", "0"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("--nodata needs a scenario with truth.terrain.elevation_file"));
}

/// P-DEM-MASK.
/// P-DEM-UNITS. Commands print what was converted, and fly over no masked cell.
#[test]
fn commands_say_what_was_converted_and_leave_masked_cells_out() {
    let mission = Mission::new("unit");
    let metadata =
        "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">ft</Item></GDALMetadata>";
    let counts: Vec<bool> = (0..SIDE * SIDE).map(|index| index >= 6 * SIDE).collect();
    let mask = Mask { counts, bits: 1, packing: Packing::Deflate, rows: SIDE, after_overview: true };
    let file = GeoTiff { metadata: Some(metadata), mask: Some(mask), ..model(None) };
    std::fs::write(mission.path("dem.tif"), file.bytes()).unwrap();
    for words in [&["terrain", "check", "dem.tif"][..], &["run", "--lockstep", "--dem", "dem.tif"]] {
        assert!(
            told(&mission, words)
                .contains("heights are measured in the foot of 0.3048 m: converted to metres")
        );
    }
    let check = checked(&mission, &[]);
    assert!((check["brief"]["datum_m"].as_f64().unwrap() - 365.76).abs() < 1.0);
    assert_eq!(check["findings"][0]["finding"], "ground_converted");
    assert_eq!(check["impassable_share"].as_f64().unwrap(), 0.15);
}

/// P-DEM-CONVERT: With `--convert`, a format that is not supported is converted by one printed
/// command of GDAL; without it, the refusal prints the command.
// Long: one program stands in for GDAL, and is called again for each change.
#[test]
fn a_format_that_is_not_read_is_converted_by_one_printed_command() {
    let mission = Mission::new("convert");
    std::fs::write(mission.path("dem.img"), "EHFA_HEADER_TAG and so on").unwrap();
    std::fs::write(mission.path("made.tif"), model(None).bytes()).unwrap();
    let run = |words: &[&str], path: &std::path::Path| {
        let words = [&["terrain", "check", "dem.img"], words].concat();
        mission.hopper(&words).env("PATH", path).output().unwrap()
    };
    let programs = mission.path("programs");
    std::fs::create_dir(&programs).unwrap();
    let refused = run(&[], &programs);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        stderr(&refused).contains("gdal_translate") && stderr(&refused).contains("--convert"),
        "{}",
        stderr(&refused)
    );
    let missing = run(&["--convert"], &programs);
    assert_eq!(missing.status.code(), Some(2));
    assert!(stderr(&missing).contains("install gdal-bin"), "{}", stderr(&missing));

    // A program that writes down how it was called, and makes a GeoTIFF.
    let program = programs.join("gdal_translate");
    let script = format!(
        "#!/bin/sh\nfor word; do out=\"$word\"; done\necho \"$@\" >> {0}/called\necho \"$GDAL_SKIP\" >> {0}/called\n/bin/cp {0}/made.tif \"$out\"\n",
        mission.path("").display()
    );
    std::fs::write(&program, script).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let converted = run(&["--convert"], &programs);
    assert_eq!(converted.status.code(), Some(0), "{}", stderr(&converted));
    let printed = "converting: gdal_translate -q -of GTiff -co COMPRESS=DEFLATE ";
    assert!(stderr(&converted).contains(printed), "{}", stderr(&converted));
    assert!(mission.path("dem.img.converted.tif").exists());
    let called = || std::fs::read_to_string(mission.path("called")).unwrap();
    let source = mission.path("dem.img").canonicalize().unwrap();
    assert!(called().contains(&format!(" {} ", source.display())), "an absolute path: {}", called());
    assert!(called().contains("-if HFA") && !called().contains("-if VRT"), "{}", called());
    assert!(called().lines().nth(1).unwrap().starts_with("VRT,"), "{}", called());
    // What was converted once is read again, and what is read needs no conversion.
    let words = ["scenario", "check", "--dem", "dem.img", "--convert"];
    let again = mission.hopper(&words).env("PATH", &programs).output().unwrap();
    assert_eq!(again.status.code(), Some(0), "{}", stderr(&again));
    let plain = mission.hopper(&["scenario", "check", "--dem", "made.tif", "--convert"]).output().unwrap();
    assert_eq!(plain.status.code(), Some(0), "{}", stderr(&plain));
    assert_eq!(called().lines().count(), 2, "GDAL ran once: {}", called());
    // A header beside the source, a corrected one, an older source: each is another model.
    let old = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_000_000_000);
    type Change<'a> = (&'a str, &'a dyn Fn(&std::path::Path));
    let changes: [Change<'_>; 4] = [
        ("dem.hdr", &|path| std::fs::write(path, "data type = 3").unwrap()),
        ("dem.hdr", &|path| std::fs::write(path, "data type = 4 ").unwrap()),
        ("dem.img.aux.xml", &|path| std::fs::write(path, "<PAMDataset/>").unwrap()),
        ("dem.img", &|path| {
            std::fs::File::options().write(true).open(path).unwrap().set_modified(old).unwrap()
        }),
    ];
    for (index, (name, change)) in changes.iter().enumerate() {
        change(&mission.path(name));
        for _ in 0..2 {
            let again = mission.hopper(&words).env("PATH", &programs).output().unwrap();
            assert_eq!(again.status.code(), Some(0), "{}", stderr(&again));
            assert_eq!(called().lines().count(), 4 + 2 * index, "{name}");
        }
    }
    // A label beside an image that GDAL does not open is named.
    std::fs::write(mission.path("P.IMG"), "cells").unwrap();
    std::fs::write(mission.path("P.LBL"), "PDS_VERSION_ID = PDS3").unwrap();
    std::fs::write(&program, "#!/bin/sh\nexit 1\n").unwrap();
    let words = ["terrain", "check", "P.IMG", "--convert"];
    let refused = mission.hopper(&words).env("PATH", &programs).output().unwrap();
    assert!(stderr(&refused).contains("P.LBL"), "{}", stderr(&refused));
}

/// P-DEM-FILL. All commands refuse or warn alike if the part that is flown is nothing but fill.
#[test]
fn every_command_refuses_a_middle_of_nothing_but_fill() {
    let mission = Mission::new("middle");
    let side = 300;
    let height = |index: usize| {
        if index < 60 * side { 1200.0 + 2.0 * (index as f64 / 23.0).sin() } else { -9999.0 }
    };
    let file = GeoTiff::new(side, side, (0..side * side).map(height).collect());
    std::fs::write(mission.path("dem.tif"), file.bytes()).unwrap();
    let commands: [&[&str]; 4] = [
        &["terrain", "check", "dem.tif", "--crop", "100,100,64,64"],
        &["scenario", "check", "--dem", "dem.tif"],
        &["scenario", "new", "--dem", "dem.tif"],
        &["run", "--lockstep", "--dem", "dem.tif"],
    ];
    for words in commands {
        let output = mission.hopper(words).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        for said in ["dem.tif", "need heights", "-9999 looks like nodata", "--nodata none"] {
            assert!(stderr(&output).contains(said), "{said} is missing in {}", stderr(&output));
        }
    }
    assert!(told(&mission, &["terrain", "check", "dem.tif"]).contains("-9999 looks like nodata"));
}

/// P-DEM-FILL. Every command reports dropped cells and a nodata value that no cell holds; the error
/// about steep ground names the file.
#[test]
fn every_command_says_what_is_dropped_and_what_no_cell_holds() {
    let mission = Mission::new("dropped");
    std::fs::write(mission.path("dem.tif"), model(Some(1e20)).bytes()).unwrap();
    std::fs::write(mission.path("fill.tif"), model(Some(-9999.0)).bytes()).unwrap();
    for command in [&["terrain", "check"][..], &["scenario", "check", "--dem"], &["scenario", "new", "--dem"]]
    {
        let of = |words: &[&str]| told(&mission, &[command, words].concat());
        assert!(of(&["dem.tif"]).contains("240 cells hold 1e20 m, beyond 1e6 m"), "{command:?}");
        let mistaken = of(&["fill.tif", "--nodata", "9999"]);
        assert!(mistaken.contains("no cell that was read holds 9999"), "{mistaken}");
        assert!(mistaken.contains("-9999 looks like nodata"), "{mistaken}");
    }
    // Cells of 0.1 m and a fill that is kept.
    let level = |index: usize| if index < 6 * SIDE { -9999.0 } else { 1200.0 + (index % SIDE) as f64 / 1e3 };
    let steep = GeoTiff {
        scale: Some(vec![0.1, 0.1, 0.0]),
        ..GeoTiff::new(SIDE, SIDE, (0..SIDE * SIDE).map(level).collect())
    };
    std::fs::write(mission.path("steep.tif"), steep.bytes()).unwrap();
    let refused =
        mission.hopper(&["scenario", "check", "--dem", "steep.tif", "--nodata", "none"]).output().unwrap();
    for said in ["steep.tif", "-9999 to", "--nodata VALUE"] {
        assert!(stderr(&refused).contains(said), "{said} is missing in {}", stderr(&refused));
    }
}
