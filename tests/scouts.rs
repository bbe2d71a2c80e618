//! A rover with a helicopter, each with a planner process of its own, fly as lockstep does.

use crate::harness::{Mission, json, leaders, lockstep, stderr};

/// Decisions after which processes of a mission in three stages are killed: two in the first stage, one in each of the others.
const KILLS: [u64; 4] = [5, 20, 60, 95];

const SCENARIO: [&str; 2] = ["--scenario", "rover-helicopter"];

/// P-SCOUT-RUN: A rover and a helicopter, each with a planner process, have the digest of lockstep.
#[test]
fn a_rover_with_a_helicopter_flown_live_has_the_digest_of_lockstep() {
    for planner in [None, Some("ett_exact"), Some("scout_value")] {
        let mut mission = Mission::new("scouts");
        let given = planner.map(|name| ["--planner", name]).into_iter().flatten();
        let words: Vec<&str> = SCENARIO.into_iter().chain(given).collect();
        let output = mission.fly(&words);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let summary = json(&output);
        assert_eq!(summary["digest"], lockstep(&words)["digest"], "{}", stderr(&output));
        mission.assert_as_lockstep("out/journal");
        let log = stderr(&output);
        assert!(log.contains("goal: decision") && log.contains("the mission is over: goal"), "{log}");
        // Rover and helicopter see a part of the map, and not all of it.
        let seen = summary["coverage"].as_f64().unwrap();
        assert!(seen > 0.05 && seen < 0.9, "{summary}");
        let processes = summary["processes"].as_array().unwrap();
        assert_eq!(processes.iter().filter(|process| process["role"] == "planner").count(), 2, "{summary}");
        mission.assert_nothing_left();
    }
}

/// P-SENSOR-RUN: A live mission whose helicopter has a camera that errs has the digest of lockstep.
#[test]
fn a_helicopter_that_errs_flies_live_as_in_lockstep() {
    let mut mission = Mission::new("scouts-err");
    let scenario = include_str!("../scenarios/rover-helicopter.toml");
    let erring = mission.path("erring.toml");
    std::fs::write(&erring, format!("{scenario}accuracy = 0.9\n")).unwrap();
    let words = ["--scenario", erring.to_str().unwrap()];
    let output = mission.fly(&words);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let (live, exact) = (json(&output)["digest"].clone(), lockstep(&SCENARIO)["digest"].clone());
    assert_eq!(live, lockstep(&words)["digest"], "{}", stderr(&output));
    assert_ne!(live, exact, "its errors change the mission");
    mission.assert_as_lockstep("out/journal");
    mission.assert_nothing_left();
}

/// A rover that takes three Sol, in as many stages, in the folder of a mission.
fn in_three_stages(mission: &Mission) -> std::path::PathBuf {
    let scenario = include_str!("../scenarios/rover-helicopter.toml");
    let path = mission.path("stages.toml");
    let scenario = scenario.replace("seed = 1", "seed = 124").replace("rrt_star_it", "scout_route");
    let scenario = scenario + "\n[sampling]\nstages = 3\n";
    std::fs::write(&path, scenario).unwrap();
    path
}

/// P-STAGES-RUN: A mission of several stages whose processes are each killed and restarted has the
/// digest and journal of lockstep.
#[test]
fn a_mission_of_several_stages_flies_live_as_in_lockstep() {
    let mission = Mission::new("scouts-stages");
    let path = in_three_stages(&mission);
    let words = ["--scenario", path.to_str().unwrap()];
    mission.kill_each_of_two(&words, "10", ["rrt_star_ett", "scout_route"], KILLS);
    let shown = json(&mission.hopper(&["journal", "show", "journal", "--format", "json"]).output().unwrap());
    let halted = |record: &&serde_json::Value| record["outcome"]["branch"] == "halted";
    let halts: Vec<_> = shown["records"].as_array().unwrap().iter().filter(halted).collect();
    assert_eq!(halts.len(), 2, "{halts:?}");
    let ends = [0, 1].map(|stage: usize| halts[stage]["decision"].as_u64().unwrap());
    let deaths = KILLS.map(|death| ends.iter().filter(|end| **end < death).count());
    assert_eq!(deaths, [0, 0, 1, 2], "stages end at {ends:?}");
}

/// P-SCOUT-KILL: Any process of a mission of rover and helicopter may be killed and restarted; the
/// journal is that of lockstep.
#[test]
fn any_process_of_rover_and_helicopter_may_die_and_the_journal_is_that_of_lockstep() {
    let mission = Mission::new("scouts-kill");
    mission.kill_each_of_two(&SCENARIO, "10", ["rrt_star_ett", "rrt_star_it"], [3, 8, 13, 20]);
}

/// P-SCOUT-TAKEOVER: In a live mission the helicopter's planner can be swapped while the rover's
/// carries on in its own term.
#[test]
fn the_helicopters_planner_is_swapped_live_and_the_rovers_goes_on() {
    let mission = Mission::new("scouts-swap");
    let begun = mission.start_sim_until(7, &SCENARIO);
    let _perception = mission.start("perception", &[]);
    let mut rover = mission.start("planner", &["--robot", "0", "--algorithm", "rrt_star_ett"]);
    let mut first = mission.start("planner", &["--robot", "1", "--algorithm", "rrt_star_it"]);
    let words = ["--robot", "1", "--algorithm", "scout_value"];
    let (mut sim, mut second) = mission.hand_over(begun, &SCENARIO, Some(&first), &words);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!((rover.code(), first.code(), second.code()), (0, 0, 0));
    let mut led = leaders(&mission.verified());
    led.sort();
    let name = |name: &str| name.to_owned();
    let expected = [(0, 1, name("rrt_star_ett")), (1, 1, name("rrt_star_it")), (1, 2, name("scout_value"))];
    assert_eq!(led, expected);
    mission.assert_as_lockstep("journal");
}

/// P-SCOUT-UNSUITED: Planners that cannot plan for rover and helicopter are refused by name, and so
/// are planners of rover and helicopter in other missions.
#[test]
fn planners_of_other_missions_are_refused_by_name() {
    let mission = Mission::new("scouts-unsuited");
    for (scenario, planner, need) in [
        ("rover-helicopter", "mdp", "rrt_star, rrt_star_ett, ett_exact"),
        ("rover-helicopter", "spiral", "rrt_star, rrt_star_ett, ett_exact"),
        ("hard", "rrt_star_it", "mdp"),
        ("coverage", "rrt_star_ett", "spiral"),
    ] {
        let output = mission.fly(&["--scenario", scenario, "--planner", planner]);
        assert_eq!(output.status.code(), Some(2));
        let error = stderr(&output);
        assert!(error.contains(&format!("scenario {scenario} needs one of the planners {need}")), "{error}");
    }
}
