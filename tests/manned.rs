//! A team of which a planner is missing: who that is, how it is told, and how it ends.

use crate::harness::{Mission, Process, eventually, json, lockstep, stderr};
use rustix::process::{Pid, Signal, kill_process};

/// The process of `run` that plans for that robot, unless it is `last`.
fn planner_of(run: &Process, robot: &str, last: Option<i32>) -> Option<i32> {
    run.children().into_iter().filter(|pid| Some(*pid) != last).find(|pid| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let words: Vec<&[u8]> = line.split(|byte| *byte == 0).collect();
        words.get(1) == Some(&&b"planner"[..])
            && words.windows(2).any(|two| two == [b"--robot", robot.as_bytes()])
    })
}

/// `hopper run` of eight rovers, of which the planner of robot 3 has been killed until it was given up.
fn without_planner_of_3(mission: &Mission, patience: &str) -> Process {
    let name = mission.name.as_str();
    let words = ["run", "--instance", name, "--out", "out", "--scenario", "coverage-8", "--format", "json"];
    let mut command = mission.hopper(&words);
    command.args(["--pace", "20", "--patience", patience]);
    let run = Process::spawn("run", command, &mission.path(""));
    let mut last = None;
    for _ in 0..6 {
        eventually("a planner of robot 3", || match planner_of(&run, "3", last) {
            Some(pid) => {
                last = Some(pid);
                true
            }
            None => false,
        });
        kill_process(Pid::from_raw(last.unwrap()).unwrap(), Signal::KILL).unwrap();
    }
    run.await_log("giving it up");
    run
}

/// P-MANNED-END: patience ends a mission of which one planner was given up; the log names its robot and the command.
#[test]
fn a_team_that_lacks_one_planner_holds_no_longer_than_patience() {
    let mut mission = Mission::new("unmanned");
    let mut run = without_planner_of_3(&mission, "1s");
    assert_eq!(run.code(), 1, "{}", run.log());
    let log = run.log();
    let hint = format!("`hopper planner --instance {} --robot 3 --algorithm ", mission.name);
    assert_eq!(log.matches("the mission holds without a planner of robot 3").count(), 1, "{log}");
    assert!(log.contains(&hint) && log.contains("planner of robot 3 died"), "{log}");
    assert!(log.contains("the mission held for 1s without a planner of robot 3"), "{log}");
    mission.assert_nothing_left();
}

/// P-MANNED-HELP: the command of the hint brings the mission to its end, with the digest of lockstep.
#[test]
fn a_team_goes_on_with_the_planner_that_the_hint_names() {
    let mission = Mission::new("manned");
    let mut run = without_planner_of_3(&mission, "10m");
    run.await_log("the mission holds without a planner of robot 3");
    let log = run.log();
    let (_, hint) = log.split_once("start another with `hopper planner ").unwrap();
    let words: Vec<&str> = hint.split('`').next().unwrap().split(' ').skip(2).collect();
    let mut helper = mission.start("planner", &words);
    assert_eq!(run.code(), 0, "{}", run.log());
    assert_eq!(helper.code(), 0, "{}", helper.log());
    assert_eq!(run.json()["digest"], lockstep(&["--scenario", "coverage-8"])["digest"]);
}

/// P-MANNED: hopper-sim, doctor and the line of the wait name each robot that acts and has no planner.
#[test]
fn robots_without_a_planner_are_named_before_their_turn_comes() {
    let mission = Mission::new("alone");
    let perception = mission.start("perception", &[]);
    let planner = mission.start("planner", &["--robot", "0", "--algorithm", "spiral"]);
    // A planner of another task plans for nobody.
    let unsuited = mission.start("planner", &["--robot", "2", "--algorithm", "mdp"]);
    for peer in [&perception, &planner, &unsuited] {
        peer.await_log("joined");
    }
    let mut sim = mission.start("sim", &["--scenario", "coverage", "--wait", "10s"]);
    let missing = "a planner of robots 1, 2 and 3";
    let command = "--robot 1,2,3";
    eventually("doctor to name the robots", || {
        let output =
            mission.hopper(&["doctor", "--instance", &mission.name, "--format", "json"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let advice = json(&output)["instances"][0]["advice"].to_string();
        let hint = format!("`hopper planner --instance {} {command}`", mission.name);
        sim.has_ended().is_some() || advice.contains(&format!("{missing} is missing: start {hint}"))
    });
    assert!(sim.has_ended().is_none(), "{}", sim.log());
    assert_eq!(sim.code(), 4, "{}", sim.log());
    let log = sim.log();
    for line in ["waiting for", "waited 10s for"] {
        assert!(log.contains(&format!("{line} {missing} (hopper planner {command})")), "{log}");
    }
}
