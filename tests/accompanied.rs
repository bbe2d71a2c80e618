//! A hopper with a helicopter, each with a planner process of its own, fly as lockstep does.

use crate::harness::{Mission, json, leaders, lockstep, stderr};

const SCENARIO: [&str; 2] = ["--scenario", "hopper-scout"];

/// P-ACCOMPANIED-RUN: A hopper and a helicopter, each with a planner process, have the digest of
/// lockstep.
#[test]
fn a_hopper_with_a_helicopter_flown_live_has_the_digest_of_lockstep() {
    for planner in [None, Some("astar")] {
        let mut mission = Mission::new("accompanied");
        let given = planner.map(|name| ["--planner", name]).into_iter().flatten();
        let words: Vec<&str> = SCENARIO.into_iter().chain(given).collect();
        let output = mission.fly(&words);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let summary = json(&output);
        assert_eq!(summary["digest"], lockstep(&words)["digest"], "{}", stderr(&output));
        mission.assert_as_lockstep("out/journal");
        let hops = summary["hops"].as_u64().unwrap();
        assert!(hops >= 93 && hops < summary["decisions"].as_u64().unwrap(), "{summary}");
        let picture = std::fs::read_to_string(mission.path("out/mission.svg")).unwrap();
        assert!(picture.contains("helicopter 1") && picture.contains("goal"), "both are in the picture");
        mission.assert_nothing_left();
    }
}

/// P-ACCOMPANIED-KILL: Any process of a mission of hopper and helicopter may be killed and
/// restarted; the journal is that of lockstep.
#[test]
fn any_process_of_hopper_and_helicopter_may_die_and_the_journal_is_that_of_lockstep() {
    let mission = Mission::new("accompanied-kill");
    mission.kill_each_of_two(&SCENARIO, "20", ["mdp", "scout_ahead"], [5, 20, 40, 60]);
}

/// P-ACCOMPANIED-TAKEOVER: In a live mission the hopper's planner can be swapped while the
/// helicopter's carries on in its own term.
#[test]
fn the_hoppers_planner_is_swapped_live_and_the_helicopters_goes_on() {
    let mission = Mission::new("accompanied-swap");
    let begun = mission.start_sim_until(20, &SCENARIO);
    let _perception = mission.start("perception", &[]);
    let mut first = mission.start("planner", &["--robot", "0", "--algorithm", "mdp"]);
    let mut helicopter = mission.start("planner", &["--robot", "1", "--algorithm", "scout_ahead"]);
    let words = ["--robot", "0", "--algorithm", "astar"];
    let (mut sim, mut second) = mission.hand_over(begun, &SCENARIO, Some(&first), &words);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!((first.code(), helicopter.code(), second.code()), (0, 0, 0));
    let mut led = leaders(&mission.verified());
    led.sort();
    let name = |name: &str| name.to_owned();
    assert_eq!(led, [(0, 1, name("mdp")), (0, 2, name("astar")), (1, 1, name("scout_ahead"))]);
    mission.assert_as_lockstep("journal");
}

/// P-ACCOMPANIED-UNSUITED: Where a hopper has a helicopter, planners that do not suit and
/// impossible teams are each refused with one error.
#[test]
fn planners_and_teams_that_cannot_be_are_refused_by_name() {
    let mission = Mission::new("accompanied-unsuited");
    for (scenario, planner, need) in [
        ("hopper-scout", "rrt_star_it", "mdp, greedy"),
        ("hopper-scout", "spiral", "mdp, greedy"),
        ("large", "scout_ahead", "mdp, greedy"),
        ("rover-helicopter", "scout_ahead", "rrt_star, rrt_star_ett, ett_exact"),
    ] {
        let output = mission.fly(&["--scenario", scenario, "--planner", planner]);
        assert_eq!(output.status.code(), Some(2));
        let error = stderr(&output);
        assert!(error.contains(&format!("scenario {scenario} needs one of the planners {need}")), "{error}");
    }
    let text = include_str!("../scenarios/hopper-scout.toml");
    let hopper = "[[robots]]\nbody = \"hopper\"\nplanner = \"mdp\"\n";
    for (old, new, need) in [
        (hopper, "", "brief.start: need none, since no robot takes its start from there"),
        (hopper, &hopper.repeat(2), "robots.start: need a cell of its own for each robot on the ground"),
        ("body = \"helicopter\"", "body = \"rover\"", "unknown field `budget_m`"),
        ("budget_m = 150.0", "budget_m = -1.0", "robots.budget_m: need 0 to 1e6 m, got -1"),
        ("speed_mps = 5.0", "speed_mps = 0.0", "robots.speed_mps: need 0.001 to 1000 m/s, got 0"),
        ("view_radius_m = 5.0", "start = [50, 2]", "robots.start: need a cell on the map"),
    ] {
        assert!(text.contains(old), "{old}");
        std::fs::write(mission.path("team.toml"), text.replace(old, new)).unwrap();
        let output = mission.fly(&["--scenario", mission.path("team.toml").to_str().unwrap()]);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(need), "{need}: {error}");
    }
}
