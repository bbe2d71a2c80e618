//! Planners swap while the hopper is in the field: no hop lost, none executed twice.

use crate::harness::{self, Mission, lockstep};
use rustix::process::Signal;
use serde_json::Value;

/// Names in command, in order.
fn commanders(summary: &Value) -> Vec<String> {
    let planners = summary["planners"].as_array().unwrap();
    planners.iter().map(|planner| planner["name"].as_str().unwrap().to_owned()).collect()
}

/// The journal is whole, and lockstep with the same planners repeats it.
fn assert_exactly_once(mission: &Mission, digest: &Value, words: &[&str]) {
    let verified = mission.verified();
    assert_eq!(verified["contiguous"], true);
    assert_eq!(verified["duplicates"], 0);
    assert_eq!(&verified["digest"], digest);
    mission.assert_as_lockstep("journal");
    let journal = mission.journal();
    let again = ["--planners-from", journal.to_str().unwrap()];
    assert_eq!(&lockstep(&again)["digest"], digest, "lockstep repeats the swapped mission");
    let mut told = again.to_vec();
    told.extend(words);
    assert_eq!(&lockstep(&told)["digest"], digest, "saying which mission it is changes nothing");
}

/// P-SWAP: Planners can be swapped in flight, both ways: no hop is lost, none is executed twice,
/// and lockstep repeats the mission.
#[test]
fn a_planner_is_swapped_live_both_ways() {
    for (first, second) in [("mdp", "greedy"), ("greedy", "mdp")] {
        let mission = Mission::new("swap");
        let words = ["--seed", "8"];
        let slow = mission.start_slow_sim("8");
        let _perception = mission.start("perception", &[]);
        let mut old = mission.start("planner", &["--algorithm", first]);
        let _monitor = mission.start("monitor", &[]);
        mission.await_decisions(2);
        let mut new = mission.start("planner", &["--algorithm", second, "--takeover"]);
        new.await_log("in command");
        old.await_log("standing by");
        let mut sim = mission.hurry(slow, "8");
        let code = sim.code();
        let summary = sim.json();
        assert_eq!(commanders(&summary), [first, second], "{summary}");
        assert_eq!(summary["planners"][1]["term"], 2);
        let (to, from) = (&summary["planners"][0]["to_decision"], &summary["planners"][1]["from_decision"]);
        assert_eq!(to.as_u64().unwrap() + 1, from.as_u64().unwrap(), "no decision between the two");
        assert_eq!(code == 0, summary["outcome"] == "goal");
        assert_eq!((old.code(), new.code()), (0, 0));
        assert_exactly_once(&mission, &summary["digest"], &words);
    }
}

/// P-STANDBY: A stand-by planner takes over when the leader is killed.
#[test]
fn a_stand_by_takes_over_when_the_leader_is_killed() {
    let mission = Mission::new("standby");
    let words = ["--seed", "9"];
    let slow = mission.start_slow_sim("9");
    let _perception = mission.start("perception", &[]);
    let mut leader = mission.start("planner", &[]);
    leader.await_log("in command");
    let standby = mission.start("planner", &["--algorithm", "greedy"]);
    let _monitor = mission.start("monitor", &[]);
    standby.await_log("joined");
    mission.await_decisions(2);
    assert!(!standby.log().contains("in command"), "{}", standby.log());
    leader.kill();
    standby.await_log("in command");
    let summary = mission.hurry(slow, "9").json();
    assert_eq!(commanders(&summary), ["mdp", "greedy"], "{summary}");
    assert_exactly_once(&mission, &summary["digest"], &words);
}

/// P-HANG: A stopped leader is replaced, and steps back when it wakes.
#[test]
fn a_stopped_leader_is_relieved_and_steps_back_when_it_wakes() {
    let mission = Mission::new("stopped");
    let words = ["--seed", "10"];
    let slow = mission.start_slow_sim("10");
    let _perception = mission.start("perception", &[]);
    let leader = mission.start("planner", &[]);
    leader.await_log("in command");
    let standby = mission.start("planner", &["--algorithm", "greedy"]);
    let _monitor = mission.start("monitor", &[]);
    standby.await_log("joined");
    mission.await_decisions(2);
    leader.stop();
    standby.await_log("in command");
    leader.signal(Signal::CONT);
    leader.await_log("standing by");
    let summary = mission.hurry(slow, "10").json();
    assert_eq!(commanders(&summary), ["mdp", "greedy"], "{summary}");
    assert_exactly_once(&mission, &summary["digest"], &words);
}

/// P-RIVALS: If two planners start at once, exactly one commands.
#[test]
fn of_two_planners_at_once_one_commands() {
    let mission = Mission::new("rivals");
    let _perception = mission.start("perception", &[]);
    let _monitor = mission.start("monitor", &[]);
    let rivals = [mission.start("planner", &[]), mission.start("planner", &[])];
    rivals.iter().for_each(|rival| rival.await_log("joined"));
    let mut sim = mission.start("sim", &["--seed", "11"]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    let summary = sim.json();
    assert_eq!(commanders(&summary), ["mdp"]);
    assert_eq!(summary["planners"][0]["term"], 1);
    assert_exactly_once(&mission, &summary["digest"], &["--seed", "11"]);
}

/// P-TAKEOVER-ONCE: `--takeover` takes effect once per process.
#[test]
fn two_takeovers_do_not_fight_without_end() {
    let mission = Mission::new("fight");
    let mut sim = mission.start("sim", &["--seed", "12", "--pace", "50"]);
    let _perception = mission.start("perception", &[]);
    let _monitor = mission.start("monitor", &[]);
    let planners = [
        mission.start("planner", &[]),
        mission.start("planner", &["--algorithm", "greedy", "--takeover"]),
        mission.start("planner", &["--algorithm", "mdp", "--takeover"]),
    ];
    sim.code();
    let summary = sim.json();
    let terms = summary["planners"].as_array().unwrap().len();
    assert!(terms <= planners.len(), "each takeover fires once: {summary}");
    assert_exactly_once(&mission, &summary["digest"], &["--seed", "12"]);
}

/// P-SWAP-RUN: A planner can join a mission that `hopper run` started, and take it over.
#[test]
fn a_planner_takes_over_a_mission_of_hopper_run() {
    let mission = Mission::new("guest");
    let name = mission.name.clone();
    let run = |pace: &str| {
        let mut command = mission.hopper(&["run", "--instance", &name, "--out", ".", "--format", "json"]);
        command.args(["--seed", "13", "--pace", pace]);
        harness::Process::spawn("run", command, &mission.path(""))
    };
    let mut slow = run("0.5");
    mission.await_decisions(2);
    let mut guest = mission.start("planner", &["--algorithm", "greedy", "--takeover"]);
    guest.await_log("in command");
    slow.signal(Signal::TERM);
    assert_eq!(slow.code(), 130, "{}", slow.log());
    // The guest lives on and goes on commanding when the run is taken up again.
    let mut fast = run("max");
    fast.code();
    let summary = fast.json();
    assert_eq!(commanders(&summary), ["mdp", "greedy"], "{summary}");
    assert_eq!(guest.code(), 0, "{}", guest.log());
    assert_exactly_once(&mission, &summary["digest"], &["--seed", "13"]);
}
