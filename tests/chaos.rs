//! Processes die at every named point and at random, and the mission ends with the undisturbed digest.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod harness;

use std::time::Duration;

use harness::{Mission, Process, lockstep};
use serde_json::Value;

const ROLES: [&str; 4] = ["sim", "perception", "planner", "monitor"];

/// Words that start a role in a mission of `seed`.
fn words<'a>(role: &str, seed: &'a str, pace: &'a str) -> Vec<&'a str> {
    if role == "sim" { vec!["--seed", seed, "--pace", pace] } else { Vec::new() }
}

/// Flies a mission in which `role` starts with `environment`, and is started again whenever it dies.
fn fly_with(role: &str, environment: &[(&str, &str)], seed: &str) -> (Value, u32) {
    let mission = Mission::new("point");
    let mut processes: Vec<Process> = ROLES
        .iter()
        .map(|other| {
            let environment = if *other == role { environment } else { &[] };
            mission.start_with(other, &words(other, seed, "max"), environment)
        })
        .collect();
    let mut deaths = 0;
    let index = ROLES.iter().position(|other| *other == role).unwrap();
    harness::eventually("the mission to end", || {
        if processes[index].has_ended().is_some_and(|status| status.code().is_none()) {
            deaths += 1;
            processes[index] = mission.start(role, &words(role, seed, "max"));
        }
        processes[0].has_ended().is_some_and(|status| status.code().is_some())
    });
    assert_eq!(processes[0].code(), 0, "{}", processes[0].log());
    let verified = mission.verified();
    assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()));
    (processes[0].json(), deaths)
}

/// P-CRASH-POINTS: kill -9 of each role at every named crash point leaves the digest as it was.
#[test]
fn a_death_at_any_named_point_leaves_the_digest() {
    let undisturbed = lockstep(&["--seed", "21"]);
    let points = [
        ("sim", hopper_sim::CRASH_POINTS),
        ("perception", perception::shell::CRASH_POINTS),
        ("planner", planner::shell::CRASH_POINTS),
        ("monitor", monitor::shell::CRASH_POINTS),
    ];
    for (role, points) in points {
        for point in points {
            // The first passage, and one in mid-mission if there is one.
            for passage in ["", ":7"] {
                let crash = format!("{point}{passage}");
                let (summary, deaths) = fly_with(role, &[("HOPPER_CRASH", &crash)], "21");
                assert_eq!(summary["digest"], undisturbed["digest"], "{crash}");
                assert!(deaths == 1 || passage == ":7", "{crash} killed {deaths} times");
            }
        }
    }
}

/// P-KILL: kill -9 of each role at random moments leaves the digest as it was.
#[test]
fn random_kills_of_every_role_leave_the_digest() {
    let undisturbed = lockstep(&["--seed", "22"]);
    // Moments are drawn from a fixed sequence; where in the mission they fall is up to the machine.
    let mut moments = (1_u64..).map(|n| 5 + n.wrapping_mul(2_654_435_761) % 60);
    for victim in ROLES {
        let mission = Mission::new("kill");
        let mut processes: Vec<Process> =
            ROLES.iter().map(|role| mission.start(role, &words(role, "22", "60"))).collect();
        let index = ROLES.iter().position(|role| *role == victim).unwrap();
        for _ in 0..6 {
            std::thread::sleep(Duration::from_millis(moments.next().unwrap()));
            if processes[0].has_ended().is_some() || processes[index].has_ended().is_some() {
                break;
            }
            processes[index].kill();
            processes[index] = mission.start(victim, &words(victim, "22", "60"));
        }
        assert_eq!(processes[0].code(), 0, "{victim}: {}", processes[0].log());
        assert_eq!(processes[0].json()["digest"], undisturbed["digest"], "{victim}");
        let verified = mission.verified();
        assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()), "{victim}");
    }
}

/// P-RESTART: `hopper run` restarts what dies.
#[test]
fn hopper_run_restarts_whatever_dies() {
    let undisturbed = lockstep(&["--seed", "23"]);
    let mut mission = Mission::new("revive");
    let name = mission.name.clone();
    let run = |pace: &str| {
        let mut command = mission.hopper(&["run", "--instance", &name, "--out", ".", "--format", "json"]);
        command.args(["--seed", "23", "--pace", pace]);
        Process::spawn("run", command, &mission.path(""))
    };
    let mut slow = run("1");
    for (decisions, role) in (1..).zip(["planner", "perception", "sim", "monitor"]) {
        mission.await_decisions(decisions);
        kill_child(slow.pid(), role);
    }
    mission.await_decisions(6);
    slow.signal(rustix::process::Signal::TERM);
    assert_eq!(slow.code(), 130, "{}", slow.log());
    for process in slow.json()["processes"].as_array().unwrap() {
        assert_eq!(process["restarts"], 1, "{process}");
    }
    let mut fast = run("max");
    assert_eq!(fast.code(), 0, "{}", fast.log());
    assert_eq!(fast.json()["digest"], undisturbed["digest"]);
    mission.assert_nothing_left();
}

/// P-GIVE-UP: a planner that crashes in a loop is restarted a bounded number of times; then the hopper holds.
#[test]
fn a_crash_looping_planner_is_given_up_and_the_hopper_holds() {
    let mut mission = Mission::new("loop");
    let name = mission.name.clone();
    let mut command = mission.hopper(&["run", "--instance", &name, "--out", ".", "--patience", "1s"]);
    command.env("HOPPER_CRASH", "planner.map_received");
    let mut run = Process::spawn("run", command, &mission.path(""));
    assert_eq!(run.code(), 1, "{}", run.log());
    let told = run.log().matches("the hopper holds").count();
    assert_eq!(told, 1, "{}", run.log());
    assert_eq!(mission.verified()["decisions"], 0, "no hop without a planner");
    mission.assert_nothing_left();
}

/// P-WATCHER: a monitor that keeps dying is given up, and the mission goes on.
#[test]
fn a_crash_looping_monitor_stops_nobody() {
    let mut mission = Mission::new("blind");
    let name = mission.name.clone();
    let words =
        ["run", "--instance", &name, "--out", ".", "--patience", "0s", "--format", "json", "--pace", "20"];
    let mut command = mission.hopper(&words);
    command.env("HOPPER_CRASH", "monitor.joined");
    let mut run = Process::spawn("run", command, &mission.path(""));
    assert_eq!(run.code(), 0, "{}", run.log());
    assert_eq!(run.json()["digest"], lockstep(&[])["digest"]);
    mission.assert_nothing_left();
}

fn kill_child(parent: u32, role: &str) {
    let find = || {
        let tasks = std::fs::read_dir(format!("/proc/{parent}/task")).ok()?;
        let children: Vec<u32> = tasks
            .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("children")).ok())
            .flat_map(|text| text.split_whitespace().filter_map(|pid| pid.parse().ok()).collect::<Vec<_>>())
            .collect();
        children.into_iter().find(|pid| {
            std::fs::read(format!("/proc/{pid}/cmdline"))
                .is_ok_and(|line| line.split(|byte| *byte == 0).nth(1) == Some(role.as_bytes()))
        })
    };
    let mut pid = None;
    harness::eventually("the child to run", || {
        pid = find();
        pid.is_some()
    });
    let pid = rustix::process::Pid::from_raw(pid.unwrap() as i32).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
}
