//! Missions over elevation files, from the survey of the file to the digest of four processes.

use crate::harness::{Mission, hopper, json, lockstep, stderr};
use crate::tiff_writer::{GeoTiff, Packing, Sample};
use crate::tools::is_served;
use serde_json::Value;

const WIDTH: usize = 24;
const HEIGHT: usize = 20;
const NODATA: f64 = -9999.0;

/// Hills of 2 m cells around −4000 m, one cell without height; the file is called the same in every format.
const SCENARIO: &str = r#"
[truth.terrain.elevation_file]
file = "model"
[truth.sand]
below_height_m = -0.8
[brief]
name = "elevation"
profile = "hopper"
start = [2, 2]
goal = [20, 16]
datum_m = -4000
[robot]
hop_distance_m = 2.0
sensor = { gain = 2.0, offset_m = 4.0 }
[limits]
steps_max = 600
"#;

/// Heights in metres, northernmost row first, each a number that text and float32 hold exactly.
fn heights() -> Vec<f64> {
    let height = |x: usize, y: usize| {
        let relief_m = 1.5 * (x as f64 / 3.5).sin() + 1.2 * (y as f64 / 3.0).cos();
        if (x, y) == (12, 0) { NODATA } else { -4000.0 + (relief_m * 64.0).round() / 64.0 }
    };
    (0..HEIGHT).rev().flat_map(|y| (0..WIDTH).map(move |x| height(x, y))).collect()
}

fn ascii_grid(values: &[f64], width: usize) -> Vec<u8> {
    let height = values.len() / width;
    let mut text = format!(
        "ncols {width}\nnrows {height}\nxllcorner 1000\nyllcorner 4960\ncellsize 2\nNODATA_value {NODATA}\n"
    );
    for row in values.chunks(width) {
        let row: Vec<String> = row.iter().map(ToString::to_string).collect();
        text += &(row.join(" ") + "\n");
    }
    text.into_bytes()
}

fn geotiff() -> GeoTiff {
    GeoTiff { nodata: Some("-9999"), ..GeoTiff::new(WIDTH, HEIGHT, heights()) }
}

/// The same ground in files of several kinds.
fn models() -> [(&'static str, Vec<u8>); 3] {
    let tiled = GeoTiff { tiled: true, chunk: (16, 16), packing: Packing::Lzw, predictor: 3, ..geotiff() };
    [
        ("ESRI ASCII", ascii_grid(&heights(), WIDTH)),
        ("plain GeoTIFF", geotiff().bytes()),
        ("packed GeoTIFF", tiled.bytes()),
    ]
}

/// A mission's folder with the scenario and `model` as its ground.
fn mission(test: &str, model: &[u8]) -> Mission {
    let mission = Mission::new(test);
    std::fs::write(mission.path("model"), model).unwrap();
    std::fs::write(mission.path("elevation.toml"), SCENARIO).unwrap();
    mission
}

/// P-ELEVATION: Over an elevation file of any supported format, four processes reach the digest of
/// lockstep.
#[test]
fn an_elevation_file_is_crossed_with_one_digest_whatever_its_format() {
    let mut digests = Vec::new();
    for (format, model) in models() {
        let mut mission = mission("model", &model);
        let path = mission.path("elevation.toml");
        let undisturbed = lockstep(&["--scenario", path.to_str().unwrap(), "--seed", "5"]);
        assert_eq!(
            (&undisturbed["outcome"], &undisturbed["scenario"]),
            (&"goal".into(), &"elevation".into())
        );
        if digests.is_empty() {
            let words = ["--scenario", "elevation.toml", "--seed", "5", "--format", "json", "--out", "out"];
            let output = mission.hopper(&["run", "--instance", &mission.name]).args(words).output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            assert_eq!(json(&output)["digest"], undisturbed["digest"], "{format}");
            mission.assert_nothing_left();
        }
        digests.push(undisturbed["digest"].clone());
    }
    assert_eq!(digests[0], digests[1], "ESRI ASCII and GeoTIFF are one ground");
    assert_eq!(digests[1], digests[2], "packing changes nothing");
}

/// P-TERRAIN-CHECK: `terrain check` prints size, resolution, coordinates, elevations, slopes and
/// gaps, and what Hopper does with each.
#[test]
fn a_survey_tells_size_resolution_slopes_gaps_and_what_becomes_of_each() {
    for (format, model) in models() {
        let mission = mission("survey", &model);
        let check = |words: &[&str]| {
            let output = mission.hopper(&["terrain", "check", "model"]).args(words).output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{format}: {}", stderr(&output));
            output
        };
        let survey = json(&check(&["--format", "json"]));
        assert_eq!((&survey["width"], &survey["height"]), (&WIDTH.into(), &HEIGHT.into()), "{survey}");
        assert_eq!(survey["cell_size_m"], 2.0);
        assert!(!survey["coordinate_system"].as_str().unwrap().is_empty());
        let known = || heights().into_iter().filter(|height| *height != NODATA);
        assert_eq!(survey["elevation_m"]["min"], known().fold(f64::INFINITY, f64::min));
        assert_eq!(survey["elevation_m"]["max"], known().fold(f64::NEG_INFINITY, f64::max));
        let mean = survey["elevation_mean_m"].as_f64().unwrap();
        assert!((mean - known().sum::<f64>() / known().count() as f64).abs() < 1e-9, "{mean}");
        assert_eq!((&survey["nodata"], &survey["nodata_cells"]), (&NODATA.into(), &1.into()));
        assert_eq!(survey["nodata_share"], 1.0 / (WIDTH * HEIGHT) as f64);
        let percentiles = ["p50_deg", "p75_deg", "p90_deg", "p95_deg", "p99_deg", "max_deg"]
            .map(|field| survey["slope"][field].as_f64().unwrap());
        assert!(percentiles.is_sorted() && percentiles[0] > 1.0 && percentiles[5] < 30.0, "{percentiles:?}");
        assert_eq!(survey["slope"]["over_limit_share"], 0.0);
        // One cell has no height; its neighbours have their slope from the other side.
        let impassable = survey["impassable_share"].as_f64().unwrap();
        assert!(impassable >= 1.0 / (WIDTH * HEIGHT) as f64 && impassable < 0.02, "{impassable}");
        let treatment: Vec<&str> =
            survey["treatment"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        for subject in ["size", "resolution", "coordinates", "elevation", "slope", "nodata"] {
            let told = treatment.iter().any(|sentence| sentence.starts_with(subject));
            assert!(told, "{format}: what becomes of {subject}? {treatment:?}");
        }
        let gentle = json(&check(&["--format", "json", "--slope-limit", "5"]));
        assert!(gentle["slope"]["over_limit_share"].as_f64().unwrap() > 0.1, "{gentle}");
        let part = json(&check(&["--format", "json", "--crop", "2,3,10,8"]));
        assert_eq!((&part["surveyed_width"], &part["surveyed_height"]), (&10.into(), &8.into()));
        let text = String::from_utf8(check(&[]).stdout).unwrap();
        for line in ["size", "resolution", "coordinate system", "elevation", "slope", "nodata", "impassable"]
        {
            assert!(text.lines().any(|got| got.starts_with(line)), "{line} is not in {text}");
        }
    }
}

/// Fails `words` with exit code 2 and one clear message that says all of `says`.
fn refuses(mission: &Mission, words: &[&str], says: &[&str]) {
    let output = mission.hopper(words).output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {text}");
    assert!(output.stdout.is_empty(), "{words:?} wrote data");
    assert_eq!(text.trim_end().lines().count(), 1, "{words:?} is not one message: {text}");
    for part in says {
        assert!(text.contains(part), "{words:?} does not say {part:?}: {text}");
    }
}

/// P-ELEVATION-BAD: Elevation files in degrees, without heights, too large or cut short are refused
/// with one message.
#[test]
fn elevation_files_that_cannot_be_crossed_are_refused_in_one_message() {
    let degrees = GeoTiff { keys: Some(vec![(1024, 2), (1025, 1), (2048, 4326)]), ..geotiff() };
    let degrees_ascii = b"ncols 3\nnrows 2\nxllcorner 137.4\nyllcorner -4.6\ncellsize 0.001\n1 2 3\n4 5 6\n";
    let nothing = GeoTiff::new(WIDTH, HEIGHT, vec![f64::NAN; WIDTH * HEIGHT]);
    let double = GeoTiff { sample: Sample::F64, ..nothing.clone() };
    let nothing_ascii = ascii_grid(&[NODATA; WIDTH * HEIGHT], WIDTH);
    let huge = GeoTiff {
        sample: Sample::U8,
        packing: Packing::Deflate,
        chunk: (0, 16),
        ..GeoTiff::new(4200, 4200, vec![7.0; 4200 * 4200])
    };
    let huge_ascii = b"ncols 60000\nnrows 60000\nxllcorner 0\nyllcorner 0\ncellsize 2\n1 2 3\n";
    let whole = geotiff().bytes();
    let whole_ascii = ascii_grid(&heights(), WIDTH);
    for (fault, model, says) in [
        ("degrees", degrees.bytes(), &["degrees", "gdalwarp"][..]),
        ("degrees, ASCII", degrees_ascii.to_vec(), &["degrees", "gdalwarp"]),
        ("NaN", nothing.bytes(), &["need heights", "NaN"]),
        ("NaN, float64", double.bytes(), &["need heights", "NaN"]),
        ("NaN, ASCII", nothing_ascii, &["need heights"]),
        ("too large", huge.bytes(), &["crop"]),
        ("too large, ASCII", huge_ascii.to_vec(), &["crop"]),
        ("cut short", whole[..whole.len() / 2].to_vec(), &["cut short"]),
        ("cut short, ASCII", whole_ascii[..whole_ascii.len() / 2].to_vec(), &["cut short"]),
        ("cut in its header", whole[..6].to_vec(), &["cut short"]),
        ("cut in its header, ASCII", whole_ascii[..40].to_vec(), &["cut short"]),
    ] {
        let mission = mission("bad", &model);
        let says: Vec<&str> = says.iter().copied().chain(["model"]).collect();
        refuses(&mission, &["terrain", "check", "model"], &says);
        refuses(&mission, &["scenario", "check", "elevation.toml"], &says);
        refuses(&mission, &["run", "--lockstep", "--scenario", "elevation.toml", "--out", "out"], &says);
        refuses(&mission, &["sim", "--scenario", "elevation.toml", "--instance", &mission.name], &says);
        assert!(!mission.path("out").exists(), "{fault}: nothing is written for a mission that cannot be");
    }
}

/// P-ELEVATION-LARGE: A model larger than a mission allows can still be examined, and is flown once
/// it is cropped.
#[test]
fn a_model_larger_than_a_mission_is_surveyed_and_has_to_be_cropped() {
    let mission = mission("large", &ascii_grid(&[-4000.0; 1100 * 20], 1100));
    let survey = json(&mission.hopper(&["terrain", "check", "model", "--format", "json"]).output().unwrap());
    assert!(survey["treatment"][0].as_str().unwrap().contains("too large for a mission"), "{survey}");
    let fly = ["run", "--lockstep", "--scenario", "elevation.toml", "--out", "out"];
    refuses(&mission, &fly, &["crop", "1100"]);
    let cropped = SCENARIO.replace(
        "file = \"model\"",
        "file = \"model\"\ncrop_cells = { x = 500, y = 0, width = 24, height = 20 }",
    );
    std::fs::write(mission.path("elevation.toml"), cropped).unwrap();
    let output = mission.hopper(&fly).args(["--format", "json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(json(&output)["outcome"], "goal");
}

/// P-DEM: `--dem` puts another elevation model under a scenario.
#[test]
fn another_model_may_be_put_under_a_scenario() {
    let [(_, ascii), (_, tiff), _] = models();
    let mission = mission("dem", &ascii);
    std::fs::write(mission.path("other.tif"), tiff).unwrap();
    std::fs::remove_file(mission.path("model")).unwrap();
    let fly = ["run", "--lockstep", "--scenario", "elevation.toml", "--out", "out"];
    refuses(&mission, &fly, &["model", "--dem"]);
    let output = mission.hopper(&fly).args(["--dem", "other.tif", "--format", "json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let generated = hopper(&["run", "--lockstep", "--scenario", "hard", "--dem", "x.tif"]).output().unwrap();
    assert_eq!(generated.status.code(), Some(2), "{}", stderr(&generated));
}

/// P-DEM-ALONE: An elevation model alone is a mission, with hop and cells fitted to each other. If
/// a model does not fit a scenario, the error names the command that flies the model alone.
#[test]
fn an_elevation_model_alone_is_a_mission() {
    // Cells of 4.98 m, as in the crop of Mars that the scenario mars is written for: no whole number fits a metre.
    let wide = GeoTiff { scale: Some(vec![4.98, 4.98, 0.0]), ..geotiff() };
    let mission = mission("alone", &wide.bytes());
    for (seed, out) in [("1", "once"), ("2", "other")] {
        let words = ["run", "--lockstep", "--dem", "model", "--seed", seed, "--out", out, "--format", "json"];
        let output = mission.hopper(&words).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(
            (&json(&output)["outcome"], &json(&output)["scenario"]),
            (&"goal".into(), &"model".into())
        );
        assert!(stderr(&output).contains("all 24 x 20 cells, hops of 4.98 m"), "{}", stderr(&output));
    }
    let scenario = |out: &str| std::fs::read_to_string(mission.path(out).join("scenario.toml")).unwrap();
    assert_eq!(scenario("once"), scenario("other"));
    // The scenario of the output folder is the same mission.
    let words =
        ["run", "--lockstep", "--scenario", "once/scenario.toml", "--out", "again", "--format", "json"];
    let again = json(&mission.hopper(&words).output().unwrap());
    let once: Value =
        serde_json::from_slice(&std::fs::read(mission.path("once/summary.json")).unwrap()).unwrap();
    assert_eq!(again["digest"], once["digest"]);
    let checked = mission.hopper(&["scenario", "check", "--dem", "model"]).output().unwrap();
    assert_eq!(checked.status.code(), Some(0), "{}", stderr(&checked));

    let way_out = "leave --scenario out: hopper run --dem model";
    for scenario in ["mars", "hard", "elevation.toml"] {
        refuses(&mission, &["run", "--lockstep", "--scenario", scenario, "--dem", "model"], &[way_out]);
    }
    refuses(&mission, &["run", "--scenario", "mars", "--dem", "nowhere.tif"], &["--dem", "nowhere.tif"]);
    refuses(&mission, &["run", "--dem", "nowhere.tif"], &["--dem", "nowhere.tif"]);
}

/// P-NO-GROUND. A mission is repeated, compared and shown only on the ground that it was flown on.
#[test]
fn on_another_ground_a_mission_is_neither_repeated_nor_shown() {
    let mission = mission("other-ground", &geotiff().bytes());
    let flown = mission.hopper(&["run", "--lockstep", "--dem", "model", "--out", "once"]).output().unwrap();
    assert_eq!(flown.status.code(), Some(0), "{}", stderr(&flown));
    let deeper = heights()
        .into_iter()
        .map(|height| if height < -4001.0 && height != NODATA { height - 0.5 } else { height });
    let deeper = GeoTiff { nodata: Some("-9999"), ..GeoTiff::new(WIDTH, HEIGHT, deeper.collect()) };
    std::fs::write(mission.path("model"), deeper.bytes()).unwrap();
    for words in [
        &["run", "--lockstep", "--planners-from", "once"][..],
        &["journal", "verify", "once/journal", "--against-lockstep"],
        &["journal", "draw", "once/journal", "--out", "once.svg"],
        &["gif", "once", "--out", "once.gif"],
        &["view", "once", "--web", "127.0.0.1:0"],
    ] {
        if is_served(words) {
            refuses(&mission, words, &["other contents"]);
        }
    }
}

/// P-SCENARIO-NEW: `hopper scenario new --dem` writes a scenario that flies over any model that
/// `hopper run --dem` accepts, with comments, a relative path and the gravity of the body, and
/// replaces no file.
#[test]
fn a_scenario_is_written_for_a_model_and_replaces_no_file() {
    let mission = Mission::new("written");
    std::fs::write(mission.path("model.asc"), ascii_grid(&heights(), WIDTH)).unwrap();
    let new =
        || mission.hopper(&["scenario", "new", "--dem", "model.asc", "--out", "mine.toml"]).output().unwrap();
    let output = new();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let fly = |words: &[&str]| {
        let output = mission
            .hopper(&[&["run", "--lockstep", "--format", "json", "--seed", "4"], words].concat())
            .output();
        json(&output.unwrap())
    };
    let (written, fitted) = (fly(&["--scenario", "mine.toml"]), fly(&["--dem", "model.asc"]));
    assert_eq!(written["digest"], fitted["digest"], "it is the mission of hopper run --dem");
    let again = new();
    assert_eq!(again.status.code(), Some(2), "an old file stays");
    assert!(stderr(&again).contains("mine.toml"), "{}", stderr(&again));
}
