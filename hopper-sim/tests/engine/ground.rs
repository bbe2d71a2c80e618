//! Journals of missions on ground from a file, where that is at hand, gone, or another one.

use std::fs;
use std::path::Path;

use contract::RunId;
use hopper_sim::{Journal, JournalError, JournalHeader, JournalReader, verify};
use scenario::{ResolvedScenario, Scenario};
use tempfile::TempDir;

use crate::fixture::law;

/// An ASCII raster of 9 by 9 cells whose heights rise by `rise_m` a column.
fn raster(rise_m: f64, columns: usize) -> String {
    let row = (0..columns).map(|x| (x as f64 * rise_m).to_string()).collect::<Vec<_>>().join(" ");
    let head = format!("ncols {columns}\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 1\n");
    head + &format!("{row}\n").repeat(9)
}

fn scenario(dir: &Path) -> Scenario {
    let text = "[truth.terrain.elevation_file]\nfile = \"ramp.asc\"\n\
                [brief]\nstart = [1, 2]\ngoal = [7, 6]\n[robot]\nhop_distance_m = 1.0\n";
    Scenario { folder: dir.into(), ..Scenario::parse(text, "test").unwrap() }
}

/// A journal without records.
struct Begun {
    dir: TempDir,
    world: ResolvedScenario,
}

impl Begun {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("ramp.asc"), raster(0.01, 9)).unwrap();
        let begun = Self { world: scenario(dir.path()).resolve().unwrap(), dir };
        begun.write(&begun.header());
        begun
    }

    fn header(&self) -> JournalHeader {
        JournalHeader::new(&self.world, 7).with_run(RunId(5))
    }

    fn write(&self, header: &JournalHeader) {
        let _ = fs::remove_dir_all(self.journal());
        drop(Journal::create(&self.journal(), header, false).unwrap());
    }

    fn journal(&self) -> std::path::PathBuf {
        self.dir.path().join("journal")
    }

    fn ground(&self) -> std::path::PathBuf {
        self.dir.path().join("ramp.asc")
    }
}

/// P-NO-GROUND: If a file of the ground is missing or has other contents, a journal is verified
/// without executing its records, and the answer says so; it is not drawn, viewed, repeated or
/// compared with lockstep. A scenario without files always has its ground.
#[test]
fn without_its_ground_a_mission_is_verified_and_not_shown() {
    type Change = fn(&Path);
    let changes: [(Change, &str); 4] = [
        (|file| fs::remove_file(file).unwrap(), "ramp.asc"),
        (|file| fs::write(file, "not a raster").unwrap(), "ramp.asc"),
        (|file| fs::write(file, raster(0.02, 9)).unwrap(), "other contents"),
        (|file| fs::write(file, raster(0.01, 12)).unwrap(), "other contents"),
    ];
    let begun = Begun::new();
    assert_eq!(verify(&begun.journal()).unwrap().unrepeated, None);
    assert_eq!(JournalReader::open(&begun.journal()).unwrap().world().unwrap().terrain, begun.world.terrain);
    for (change, told) in changes {
        let begun = Begun::new();
        change(&begun.ground());
        let verification = verify(&begun.journal()).unwrap();
        assert_eq!(verification.faults(), [""; 0]);
        assert!(
            verification.unrepeated.as_ref().is_some_and(|reason| reason.contains(told)),
            "{verification}"
        );
        let error = JournalReader::open(&begun.journal()).unwrap().world().unwrap_err();
        assert!(matches!(&error, JournalError::NoGround { reason, .. } if reason.contains(told)), "{error}");
        assert_eq!(error.exit(), process::Exit::Usage);
    }
}

/// P-NO-GROUND.
#[test]
fn another_ground_is_told_from_another_brief() {
    let begun = Begun::new();
    let fault = |header: &JournalHeader| {
        begun.write(header);
        verify(&begun.journal()).unwrap().fault.map(|fault| fault.field.into_owned())
    };
    let mut header = begun.header();
    law(&mut header.brief).gravity_mps2 = 9.81;
    assert_eq!(fault(&header).as_deref(), Some("brief.robots.0.body.motion.gravity_mps2"));
    let gravity = header.clone();
    let mut header = begun.header();
    header.brief.grid.width += 1;
    assert_eq!(fault(&header).as_deref(), Some("brief.grid.width"));
    let mut header = begun.header();
    header.resolved = header.resolved.replace("goal = [7, 6]", "goal = [7, 5]");
    assert_ne!(header, begun.header());
    assert_eq!(fault(&header).as_deref(), Some("brief.robots.0.goal.at.y_m"));
    // Another ground, which explains another hash, does not explain another gravity.
    fs::write(begun.ground(), raster(0.02, 9)).unwrap();
    assert_eq!(fault(&gravity).as_deref(), Some("brief.robots.0.body.motion.gravity_mps2"));
    assert_eq!(fault(&begun.header()), None);
    // Nor does a text that cannot be read.
    fs::remove_file(begun.ground()).unwrap();
    assert_eq!(fault(&begun.header()), None);
    let resolved = begun.header().resolved + "\n[nonsense]\n";
    assert_eq!(fault(&JournalHeader { resolved, ..begun.header() }).as_deref(), Some("resolved"));
}

/// P-JOURNAL-FIELD. Only what the hash leaves out may differ.
#[test]
fn a_text_that_differs_under_the_same_hash_is_refused_by_field() {
    let begun = Begun::new();
    let resume = |header: &JournalHeader| {
        begun.write(header);
        Journal::resume(&begun.journal(), &begun.header(), &begun.world.terrain, false).map(drop)
    };
    let text = |from: &str, to: &str| {
        let header = begun.header();
        let resolved = header.resolved.replace(from, to);
        assert_ne!(resolved, header.resolved, "{from}");
        JournalHeader { resolved, ..header }
    };
    let file = begun.ground().canonicalize().unwrap().display().to_string();
    resume(&text(&file, "/elsewhere/ramp.asc")).unwrap();
    let nodata = text("[truth.terrain.elevation_file]", "[truth.terrain.elevation_file]\nnodata = [-9.0]");
    resume(&nodata).unwrap();
    let mut budget = text("decision_budget_ms = 600.0", "decision_budget_ms = 9.0");
    budget.brief.limits.decision_budget_ns = 9_000_000;
    resume(&budget).unwrap();
    for (header, field) in [
        (text("gravity_mps2 = 3.72", "gravity_mps2 = 9.81"), "robot.gravity_mps2"),
        (text("ramp.asc", "ridge.asc"), "truth.terrain.elevation_file.file"),
        (text("decision_budget_ms = 600.0", "decision_budget_ms = 9.0"), "brief.limits.decision_budget_ns"),
        (text("[limits]", "[limited]"), "resolved"),
    ] {
        let error = resume(&header).unwrap_err();
        assert!(matches!(&error, JournalError::Mismatch { field: got, .. } if *got == field), "{error}");
    }
}
