//! `hopper-qa fuzz-missions`: a minute of random missions of all kinds.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../tests/harness/mod.rs"]
mod harness;

use std::collections::BTreeSet;
use std::process::Command;

use harness::{Mission, json, stderr};
use hopper_qa::fuzz::trial::{self, Broken};
use hopper_qa::fuzz::{Draft, Kind, smaller};

/// P-FUZZ: Random missions of all kinds, written as scenarios, have one digest in lockstep, with
/// fresh planners, resumed, and by real processes that are killed. Missions of a hopper alone, and
/// of several robots on cells of a metre, are also flown with simulated faults.
#[test]
fn random_missions_of_all_kinds_break_no_promise() {
    let mut mission = Mission::new("fuzz");
    harness::program("hopper");
    let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-qa"));
    command.current_dir(mission.path("")).env_remove("HOPPER_INSTANCE").env_remove("HOPPER_CRASH");
    command.args(["fuzz-missions", "--seeds", "0..90", "--live", "6", "--format", "json"]);
    let output = command.output().unwrap();
    let answer = json(&output);
    assert_eq!(output.status.code(), Some(0), "{answer}{}", stderr(&output));
    assert_eq!(answer["missions"], 90, "{answer}");
    assert_eq!(answer["live"], 6, "{answer}");
    // All with cells of a metre, which most are, and all of a hopper alone.
    let simulable = (0..90).filter(|seed| {
        let draft = Draft::of(Kind::of(*seed), *seed).unwrap();
        let (mission, _) = draft.mission().unwrap();
        !mission.brief.has_team() || mission.brief.grid.cell_size_m == 1.0
    });
    let simulable = simulable.count();
    assert!(simulable >= 70, "{simulable}");
    assert_eq!(answer["simulated"], simulable, "{answer}");
    assert!(answer["decisions"].as_u64() > Some(900), "{answer}");
    mission.assert_nothing_left();
}

/// P-FUZZ-SMALL: A random mission that breaks a promise is reduced to a small one that breaks it
/// too.
#[test]
fn a_failing_mission_is_made_small() {
    for kind in Kind::ALL {
        let draft = (0..40).filter_map(|seed| Draft::of(kind, seed)).next().unwrap();
        // Every mission fails that has two decisions.
        let fails = |draft: &Draft| {
            let flown = trial::in_lockstep(draft).ok()?;
            let broken = Broken { promise: "few decisions".into(), detail: String::new() };
            (flown.records.len() >= 2).then_some(broken)
        };
        if fails(&draft).is_none() {
            continue;
        }
        let smallest = smaller::shrink(&draft, "few decisions", fails);
        assert!(fails(&smallest).is_some(), "{kind:?}");
        let size = |draft: &Draft| draft.world().unwrap().resolved.len();
        assert!(size(&smallest) <= size(&draft), "{kind:?}");
        assert!(smallest.scenario.faults.is_empty() && smallest.scenario.limits.steps_max <= 10, "{kind:?}");
    }
}

/// The same seed is the same mission, and there are missions of every kind, planner and ground.
#[test]
fn seeds_draw_missions_of_every_kind_and_planner() {
    let mut planners = BTreeSet::new();
    for seed in 0..300 {
        let kind = Kind::of(seed);
        let draft =
            Draft::of(kind, seed).unwrap_or_else(|| panic!("seed {seed} has no mission of kind {kind:?}"));
        assert_eq!(Draft::of(kind, seed).unwrap().scenario, draft.scenario, "seed {seed}");
        let (mission, named) = draft.mission().unwrap();
        assert_eq!(mission.brief.robots.len(), named.len(), "seed {seed}");
        planners.extend(named.iter().map(|name| name.to_string()));
    }
    let all = [
        planner::ALGORITHMS,
        planner::COVER_ALGORITHMS,
        planner::DRIVE_ALGORITHMS,
        planner::FLY_ALGORITHMS,
        planner::AHEAD_ALGORITHMS,
    ];
    for name in all.concat() {
        assert!(planners.contains(name), "{name} is in no mission");
    }
}
