//! A world too wide to be seen at once: the map travels as patches, and whoever comes late asks for it.

use crate::harness::{Mission, hopper, json, lockstep, stderr};
use hopper_sim::JournalReader;

const WORDS: [&str; 4] = ["--scenario", "wide", "--seed", "3"];

/// P-WIDE: On 200 × 200 cells four processes reach the digest of lockstep, and every step is timed
/// from landing to command.
#[test]
fn a_wide_world_is_crossed_with_the_digest_of_lockstep_and_every_step_timed() {
    let mut mission = Mission::new("wide");
    let output = mission.fly(&[&WORDS[..], &["--planner", "astar"]].concat());
    let summary = json(&output);
    let undisturbed = in_lockstep();
    assert_eq!(summary["digest"], undisturbed["digest"], "{}", stderr(&output));
    assert!(summary["hops"].as_u64().unwrap() > 250, "{summary}");
    let text = std::fs::read_to_string(mission.path("out/timing.csv")).unwrap();
    let mut lines = text.lines();
    let headings: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| headings.iter().position(|heading| *heading == name).unwrap();
    assert!(!headings.contains(&"commit_us"), "the journal does not have it: {headings:?}");
    let journal = JournalReader::open(&mission.path("out/journal")).unwrap();
    let mut records = journal.records();
    let mut decisions = 0;
    for line in lines {
        let moments = records.next().unwrap().unwrap().timing.moments();
        assert!(moments.is_sorted(), "nobody began anew: {moments:?}");
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!((cells.len(), cells[0]), (headings.len(), decisions.to_string().as_str()));
        let us = |name: &str| cells[column(name)].parse::<f64>().unwrap();
        let stages = ["state", "sense", "map", "deliver", "plan", "command"];
        for (stage, moments) in stages.iter().zip(moments.windows(2)) {
            let need = moments[1].since_ns(moments[0]) as f64 / 1e3;
            assert_eq!(us(&format!("{stage}_us")), need, "{stage}: {line}");
        }
        let [landed, .., accepted, _] = moments;
        assert_eq!(us("landing_to_command_us"), accepted.since_ns(landed) as f64 / 1e3, "{line}");
        assert_eq!(us("robot"), 0.0, "{line}");
        assert!(us("landing_to_command_us") > 0.0 && us("plan_us") > 0.0, "{line}");
        decisions += 1;
    }
    assert_eq!(summary["decisions"], decisions);
    for part in ["answer", "feeding"] {
        assert!(summary["latency"][part]["p50_us"].as_f64().unwrap() > 0.0, "{part} in {summary}");
    }
    mission.assert_nothing_left();
}

/// P-WIDE-LATE: Late planners and a killed perception leave the digest of a wide world unchanged.
#[test]
fn late_planners_and_a_killed_perception_leave_the_digest_of_a_wide_world() {
    let mission = Mission::new("wide-late");
    let mut sim = mission.start("sim", &WORDS);
    let mut perception = mission.start("perception", &[]);
    let mut planner = mission.start("planner", &["--algorithm", "astar"]);
    for decisions in [30, 60, 90] {
        mission.await_decisions(decisions);
        planner.kill();
        planner = mission.start("planner", &["--algorithm", "astar"]);
        mission.await_decisions(decisions + 15);
        perception.kill();
        perception = mission.start("perception", &[]);
    }
    let mut monitor = mission.start("monitor", &["--format", "json"]);
    sim.code();
    assert_eq!(sim.json()["digest"], in_lockstep()["digest"], "{}", sim.log());
    for peer in [&mut perception, &mut planner, &mut monitor] {
        assert_eq!(peer.code(), 0, "{}: {}", peer.role, peer.log());
    }
    let coverage = monitor.json()["coverage"].as_f64().unwrap();
    assert!(coverage > 0.02 && coverage < 0.9, "{coverage}");
}

fn in_lockstep() -> serde_json::Value {
    lockstep(&[&["--planner", "astar"], &WORDS[..]].concat())
}

/// P-ROOM-VAST: A mission over 821 x 821 cells needs less than 256 MB of shared memory.
#[test]
fn a_vast_mission_needs_less_than_256_mb_of_shared_memory() {
    let mission = Mission::new("vast");
    let mut sim = mission.start("sim", &["--scenario", "vast"]);
    sim.await_log("joined");
    let output = hopper(&["doctor", "--instance", &mission.name, "--format", "json"]).output().unwrap();
    let memory = &json(&output)["instances"][0]["memory"];
    let need = memory["need_bytes"].as_u64().unwrap_or_else(|| panic!("{}", json(&output)));
    assert!(need < 256_000_000 && need > 10_000_000, "{memory}");
    assert!(memory["used_bytes"].as_u64().unwrap() < need, "{memory}");
    sim.signal(rustix::process::Signal::TERM);
    assert_eq!(sim.code(), 130, "{}", sim.log());
}
