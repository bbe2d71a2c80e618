//! A team of which a planner is missing: who that is, how it is told, and how it ends.

use crate::harness::{Mission, Process, eventually, json, lockstep, stderr};
use contract::{Decision, RobotId, RobotSet, Role, RunId, Status};
use node::Node;
use process::{Membership, Terms};
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

/// P-MANNED-END: When a planner of a team was given up, `--patience` ends the mission with exit
/// code 1.
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

/// P-MANNED-HELP: The commands that `hopper run`, hopper-sim and doctor print for missing processes
/// work as printed: the mission ends with the digest of lockstep.
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

/// P-MANNED. hopper-sim, doctor and the log line of the wait name each acting robot without a
/// planner.
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
    let command = "--robot 1";
    eventually("doctor to name the robots", || {
        let output =
            mission.hopper(&["doctor", "--instance", &mission.name, "--format", "json"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let advice = json(&output)["instances"][0]["advice"].to_string();
        let hint = format!("`hopper planner --instance {} {command}`", mission.name);
        sim.has_ended().is_some()
            || advice.contains(&format!("{missing} is missing: start {hint}, and one for each"))
    });
    assert!(sim.has_ended().is_none(), "{}", sim.log());
    assert_eq!(sim.code(), 4, "{}", sim.log());
    let log = sim.log();
    for line in ["waiting for", "waited 10s for"] {
        assert!(
            log.contains(&format!(
                "{line} {missing} (hopper planner --instance {} {command}, and one for each",
                mission.name
            )),
            "{log}"
        );
    }
}

/// The command that a text names in quotation marks or parentheses after `before`, flown until it ends.
fn follow(mission: &Mission, text: &str, before: &str) -> Process {
    let (_, rest) = text.split_once(before).unwrap_or_else(|| panic!("{before:?} in {text}"));
    let words: Vec<&str> = rest.split(['`', ')', ',']).next().unwrap().split(' ').collect();
    Process::spawn(before, mission.hopper(&words), &mission.path(""))
}

/// P-MANNED-HELP. The advice of doctor and hopper-sim, word for word, brings missions of each kind
/// to their end.
#[test]
fn the_commands_that_doctor_and_hopper_sim_name_are_enough() {
    for scenario in ["hard", "coverage", "rover-helicopter", "hopper-scout"] {
        let mut mission = Mission::new("advice");
        let name = mission.name.clone();
        let mut sim = mission.start("sim", &["--scenario", scenario, "--wait", "2m"]);
        sim.await_log("waiting for perception (");
        let mut peers = vec![follow(&mission, &sim.log(), "waiting for perception (hopper ")];
        let mut advice = String::new();
        loop {
            eventually("new advice, or the end", || {
                let asked =
                    mission.hopper(&["doctor", "--instance", &name, "--format", "json"]).output().unwrap();
                let now = json(&asked)["instances"][0]["advice"].to_string();
                let is_new = now.contains("start `hopper planner") && now != advice;
                if is_new {
                    advice = now;
                }
                is_new || sim.has_ended().is_some()
            });
            if sim.has_ended().is_some() {
                break;
            }
            // Perception may not have been heard yet, and is advised too.
            let (_, of_planner) = advice.split_once("start `hopper planner ").unwrap();
            let planner = follow(&mission, &format!("start `hopper planner {of_planner}"), "start `hopper ");
            planner.await_log(" as ");
            peers.push(planner);
        }
        assert_eq!(sim.code(), 0, "{scenario}: {}", sim.log());
        for peer in &mut peers {
            assert_eq!(peer.code(), 0, "{scenario}: {}", peer.log());
        }
        assert_eq!(sim.json()["digest"], lockstep(&["--scenario", scenario])["digest"], "{scenario}");
        mission.assert_nothing_left();
    }
}

/// P-MANNED-FALLBACK: A mission that continues by the fallback of its guard is not ended because a
/// process is missing.
#[test]
fn a_team_with_a_fallback_goes_on_without_one_of_its_planners() {
    let mission = Mission::new("fallback");
    let coverage = include_str!("../scenarios/coverage.toml");
    std::fs::write(mission.path("own.toml"), format!("{coverage}\n[guard]\ndeadline_s = 0.1\n")).unwrap();
    let mut sim = mission.start("sim", &["--scenario", "own.toml", "--wait", "2s"]);
    let mut peers = vec![mission.start("perception", &[])];
    for robot in ["0", "1", "2", "3"] {
        peers.push(mission.start("planner", &["--robot", robot, "--algorithm", "spiral"]));
    }
    mission.await_decisions(4);
    peers.pop().unwrap().kill();
    // Longer than it would wait for one without whom it cannot go on.
    let begun = mission.decisions();
    std::thread::sleep(std::time::Duration::from_secs(4));
    assert!(sim.has_ended().is_none_or(|status| status.code() != Some(4)), "{}", sim.log());
    assert!(mission.decisions() > begun || sim.has_ended().is_some(), "{}", sim.log());
}

/// P-MANNED-UNDECIDED: A live planner that does not decide is named with its robot and process
/// after 10 s, and again at intervals that double.
#[test]
fn a_planner_that_thinks_for_ever_is_named() {
    let mission = Mission::new("undecided");
    let sim = mission.start("sim", &[]);
    let _perception = mission.start("perception", &[]);
    let mut node = Node::join(&mission.instance(), Role::Planner).unwrap();
    let mut thinker =
        Membership::join(&mut node, Role::Planner, "thinker".parse().unwrap(), Terms::default()).unwrap();
    thinker.tell_robots(RobotSet::NONE.with(RobotId(0)));
    let told = format!("robot 0 has waited 10 s for decision 0 of thinker (process {})", std::process::id());
    eventually(&told, || {
        thinker.beat((RunId(0), Decision(0), Status::Underway), Node::now()).unwrap();
        sim.log().contains(&told)
    });
}
