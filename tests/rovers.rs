//! Several rovers, each with a planner process of its own or sharing one, fly as lockstep does.

use crate::harness::{Mission, json, leaders, lockstep, stderr};
use rustix::process::Signal;

/// P-COVER-RUN: Missions of four and of eight rovers, each with a planner process, have the digest
/// of lockstep.
#[test]
fn rovers_flown_live_have_the_digest_of_lockstep() {
    for (scenario, rovers) in [("coverage", 4), ("coverage-8", 8)] {
        let mut mission = Mission::new("rovers");
        let output = mission.fly(&["--scenario", scenario]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let summary = json(&output);
        assert_eq!(summary["digest"], lockstep(&["--scenario", scenario])["digest"], "{}", stderr(&output));
        mission.assert_as_lockstep("out/journal");
        let processes = summary["processes"].as_array().unwrap();
        let planners = processes.iter().filter(|process| process["role"] == "planner");
        assert_eq!(planners.count(), rovers, "{summary}");
        mission.assert_nothing_left();
    }
}

/// P-COVER-KILL: Any process of a team of rovers may be killed and restarted, and two rovers may
/// share a planner. The journal is that of lockstep, and planners that were not killed keep their
/// lead.
#[test]
fn any_process_of_a_team_may_die_and_the_journal_is_that_of_lockstep() {
    let mission = Mission::new("team-kill");
    let mut sim = mission.start("sim", &["--scenario", "coverage", "--pace", "60"]);
    let mut perception = mission.start("perception", &[]);
    let first = ["--robot", "0,1", "--algorithm", "spiral"];
    let mut pair = mission.start("planner", &first);
    let mut others = mission.start("planner", &["--robot", "2,3", "--algorithm", "cover_frontier"]);
    mission.await_decisions(20);
    perception.kill();
    let mut perception = mission.start("perception", &[]);
    mission.await_decisions(60);
    pair.kill();
    let mut pair = mission.start("planner", &first);
    mission.await_decisions(100);
    sim.kill();
    let mut sim = mission.start("sim", &["--scenario", "coverage"]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    for process in [&mut perception, &mut pair, &mut others] {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
    let verified = mission.verified();
    assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()));
    let led = leaders(&verified);
    let of = |robot, term, name: &str| led.contains(&(robot, term, name.to_owned()));
    assert!(of(0, 1, "spiral") && of(0, 2, "spiral") && of(2, 1, "cover_frontier"), "{led:?}");
    assert!(!of(2, 2, "cover_frontier"), "who was not killed leads on: {led:?}");
    mission.assert_as_lockstep("journal");
}

/// P-COVER-TAKEOVER: In a live mission the planner of one rover can be swapped while the planner of
/// the others carries on.
#[test]
fn the_planner_of_one_robot_is_swapped_live() {
    let mission = Mission::new("team-swap");
    let scenario = ["--scenario", "coverage", "--pace", "60"];
    let begun = mission.start_sim_until(20, &scenario);
    let _perception = mission.start("perception", &[]);
    let mut all = mission.start("planner", &["--robot", "0,1,2,3", "--algorithm", "spiral"]);
    // The planner of all goes on: without it the mission would wait for another robot.
    let words = ["--robot", "1", "--algorithm", "cover_frontier"];
    let (mut sim, mut one) = mission.hand_over(begun, &scenario, None, &words);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!((all.code(), one.code()), (0, 0));
    let mut led = leaders(&mission.verified());
    led.sort();
    let name = |name: &str| name.to_owned();
    let spiral = |robot| (robot, 1, name("spiral"));
    assert_eq!(led, [spiral(0), spiral(1), (1, 2, name("cover_frontier")), spiral(2), spiral(3)]);
    mission.assert_as_lockstep("journal");
}

/// P-COVER-UNSUITED: If a planner does not suit the mission's task, the error names those that do:
/// `hopper run` refuses it, and a planner process waits for another mission.
#[test]
fn a_planner_that_does_not_suit_the_mission_is_refused_by_name() {
    let mission = Mission::new("unsuited");
    for (scenario, planner, need) in [("coverage", "mdp", "spiral"), ("hard", "spiral", "mdp")] {
        let output = mission.fly(&["--scenario", scenario, "--planner", planner]);
        assert_eq!(output.status.code(), Some(2));
        let error = stderr(&output);
        assert!(error.contains(&format!("scenario {scenario} needs one of the planners {need}")), "{error}");
    }
    let mut sim = mission.start("sim", &["--scenario", "coverage"]);
    let mut planner = mission.start("planner", &["--algorithm", "greedy"]);
    planner.await_log("scenario coverage needs one of the planners spiral");
    planner.signal(Signal::TERM);
    assert_eq!(planner.code(), 130, "{}", planner.log());
    sim.kill();
}
