//! `hopper endure`: a long patrol through real processes, some of which are killed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../tests/harness/mod.rs"]
mod harness;

use std::process::Command;

use harness::{Mission, json, stderr};
use serde_json::Value;

/// `hopper-qa WORDS`, in the mission's folder.
fn qa(mission: &Mission, words: &[&str]) -> Command {
    harness::program("hopper");
    let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-qa"));
    command.args(words).current_dir(mission.path("")).env_remove("HOPPER_INSTANCE");
    command
}

/// P-PATROL-FLOWN: Four processes under kills fly a patrol to the digest of lockstep, and leave
/// nothing behind. docs/measurements.md has memory and latency over a million hops (`hopper
/// endure`).
///
/// A short sample of the long run; `hopper endure` alone flies the million.
#[test]
fn a_patrol_under_kills_has_the_digest_of_lockstep_and_leaves_nothing_behind() {
    if suites::is_left_out("endurance") {
        return;
    }
    let mut mission = Mission::new("endure");
    let words = [
        "endure",
        "--hops",
        "3000",
        "--kill-every",
        "700",
        "--samples",
        "10",
        "--seed",
        "5",
        // A sample is due every 0.6 s, whatever the machine does meanwhile.
        "--pace",
        "500",
        "--format",
        "json",
    ];
    let output = qa(&mission, &words).args(["--instance", &mission.name, "--out", "out"]).output().unwrap();
    // Memory is measured over longer runs: in the first tenth of this one not every role has warmed up.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", stderr(&output));
    let answer = json(&output);
    let is = |field: &str, need: Value| assert_eq!(answer[field], need, "{field} of {answer}");
    is("outcome", "goal".into());
    is("decisions", 3000.into());
    is("kills", 4.into());
    is("leaked_nodes", 0.into());
    is("leaked_files", 0.into());
    assert!(answer["visits"].as_u64() > Some(20), "{answer}");
    assert_eq!(answer["samples"].as_array().map(Vec::len), Some(9), "{answer}");
    assert_eq!(answer["memory"].as_array().map(Vec::len), Some(4));
    assert!(answer["p50"]["half_width_us"].as_f64() > Some(0.0));
    mission.assert_nothing_left();

    let words = ["run", "--lockstep", "--scenario", "out/scenario.toml", "--seed", "5", "--format", "json"];
    let flown = mission.hopper(&words).args(["--out", "again"]).output().unwrap();
    assert_eq!(flown.status.code(), Some(0), "a patrol that is flown is a success: {}", stderr(&flown));
    let summary = json(&flown);
    assert_eq!((&summary["digest"], &summary["visits"]), (&answer["digest"], &answer["visits"]));
    assert!(mission.path("again/mission.svg").exists());
}

#[test]
fn a_mission_that_is_no_patrol_is_no_long_run() {
    let mission = Mission::new("no-patrol");
    let output = qa(&mission, &["endure", "--scenario", "hard"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("patrol"), "{}", stderr(&output));
}

/// P-COVER-LONG. A team of which every process is killed, the last of them after decision 300, has
/// the digest of lockstep.
#[test]
fn a_long_mission_of_several_robots_under_kills_ends_as_in_lockstep() {
    if suites::is_left_out("endurance") {
        return;
    }
    let mut mission = Mission::new("endure-team");
    let words =
        ["endure", "--scenario", "coverage-8", "--kill-every", "40", "--samples", "10", "--pace", "200"];
    let output = qa(&mission, &words)
        .args(["--instance", &mission.name, "--out", "out", "--format", "json"])
        .output()
        .unwrap();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", stderr(&output));
    let answer = json(&output);
    assert_eq!(answer["as_lockstep"], true, "{answer}");
    assert!(answer["decisions"].as_u64() > Some(320) && answer["kills"].as_u64() > Some(7), "{answer}");
    assert_eq!((&answer["leaked_nodes"], &answer["leaked_files"]), (&0.into(), &0.into()), "{answer}");
    mission.assert_nothing_left();
}
