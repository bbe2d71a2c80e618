//! `hopper chaos`: a small sample, and what it reports when a promise is broken.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../tests/harness/mod.rs"]
mod harness;

use std::fs;
use std::process::Command;

use harness::{Mission, Process, stderr};

fn qa(words: &[&str]) -> Command {
    harness::program("hopper");
    let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-qa"));
    command.args(words).env_remove("HOPPER_INSTANCE").env_remove("HOPPER_CRASH");
    command
}

/// P-CHAOS: Kills, stops and SIGTERM of any role, at every crash point and at random, during
/// start-up too, leave the digest of lockstep, and nothing in shared memory or directories.
/// docs/measurements.md has the counts of `hopper chaos` and the recovery times.
#[test]
fn a_sample_of_chaos_breaks_no_promise() {
    if suites::is_left_out("endurance") {
        return;
    }
    let output = qa(&["chaos", "--faults", "8", "--format", "json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let answer = harness::json(&output);
    let roles = answer["roles"].as_array().unwrap();
    assert_eq!(roles.len(), 4, "{answer}");
    for role in roles {
        let (faults, recovery) = (role["faults"].as_u64().unwrap(), &role["recovery"]);
        assert!(faults >= 8 && role["failures"] == 0, "{role}");
        assert_eq!(role["bound"], 3.0 / faults as f64, "{role}");
        assert_eq!(
            role["kinds"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum::<u64>(),
            faults
        );
        assert!(
            recovery["count"].as_u64().unwrap() <= faults
                && recovery["p50_ms"].as_f64() <= recovery["p99_ms"].as_f64()
        );
    }
}

/// P-CHAOS-SEED: If a promise breaks, `hopper chaos` exits with code 1 and prints the seed.
#[test]
fn a_broken_promise_is_told_with_its_seed() {
    let mut mission = Mission::new("seed");
    let mut command = mission.hopper(&["chaos", "--faults", "1", "--role", "monitor", "--seed", "71"]);
    command.env("TMPDIR", mission.path(""));
    let mut chaos = Process::spawn("chaos", command, &mission.path(""));
    // Of all processes the one that nobody planned to kill.
    chaos.kill_child("planner");
    assert_eq!(chaos.code(), 1, "{}", chaos.log());
    for part in [
        "seed 71 breaks: no process but the victim dies",
        "planner ended by itself",
        "again: hopper chaos --seed 71 --role monitor --faults 1",
    ] {
        assert!(chaos.out().contains(part), "{part:?} is not in {}", chaos.out());
    }
    let kept = fs::read_dir(mission.path("")).unwrap().flatten();
    let kept: Vec<_> = kept.filter(|entry| entry.path().is_dir()).collect();
    assert!(kept.len() == 1 && kept[0].path().join("planner.log").exists(), "{kept:?}");
    mission.assert_nothing_left();
}

/// P-COVER-LONG: Teams survive kills after decision 300, when their records take several pages, and
/// end with the digest of lockstep: coverage by eight rovers and missions of robots of all kinds
/// (`hopper chaos --scenario`, `hopper endure --scenario`).
#[test]
fn long_teams_survive_faults_after_decision_300() {
    if suites::is_left_out("endurance") {
        return;
    }
    for (scenario, after) in [("coverage-8", "300"), ("expedition", "300")] {
        for role in ["hopper-sim", "perception", "planner"] {
            let words = ["chaos", "--scenario", scenario, "--after", after, "--faults", "1", "--role", role];
            let output = qa(&words).args(["--format", "json"]).output().unwrap();
            let answer = harness::json(&output);
            assert_eq!(output.status.code(), Some(0), "{answer}{}", stderr(&output));
            assert!(answer["decisions"].as_u64() > Some(300), "{answer}");
        }
    }
    let beyond =
        qa(&["chaos", "--scenario", "coverage", "--after", "1000000", "--faults", "1"]).output().unwrap();
    assert_eq!(beyond.status.code(), Some(2));
    assert!(stderr(&beyond).contains("--after needs to be less than"), "{}", stderr(&beyond));
}
