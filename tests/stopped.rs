//! A process that is stopped while it joins is in the way of others, who wait as long as patience lasts.

use std::os::unix::fs::DirBuilderExt as _;
use std::time::Duration;

use crate::harness::{Mission, Process, lockstep};
use rustix::fs::{FlockOperation, flock};
use rustix::process::Signal;

/// A slow mission of `hopper run` whose hopper-sim was killed while this very test holds the right to make things in the
/// instance, as a process that was stopped while it joined would.
fn held_up(mission: &Mission, patience: &str) -> (Process, std::fs::File) {
    let name = mission.name.as_str();
    let mut command = mission.hopper(&["run", "--instance", name, "--out", ".", "--format", "json"]);
    command.args(["--seed", "8", "--pace", "5", "--patience", patience]);
    let run = Process::spawn("run", command, &mission.path(""));
    mission.await_decisions(3);
    let lock = std::fs::File::open(mission.instance().root().join("creation.lock")).unwrap();
    flock(&lock, FlockOperation::LockExclusive).unwrap();
    run.kill_child("sim");
    run.await_log("hopper-sim cannot join");
    let log = run.log();
    assert!(log.contains(&format!("in its way is process {} (", std::process::id())), "{log}");
    (run, lock)
}

/// P-HOLD-UP: A process that is stopped while it joins ends no other mission before `--patience`
/// does; its number and command are named.
#[test]
fn a_mission_goes_on_once_nobody_is_in_the_way() {
    let mut mission = Mission::new("stopped");
    let (mut run, lock) = held_up(&mission, "10m");
    // Longer than a hopper-sim once waited.
    std::thread::sleep(Duration::from_secs(6));
    assert!(run.has_ended().is_none(), "{}", run.log());
    drop(lock);
    assert_eq!(run.code(), 0, "{}", run.log());
    assert_eq!(run.json()["digest"], lockstep(&["--seed", "8"])["digest"]);
    mission.assert_nothing_left();
}

/// P-HOLD-UP. Patience ends the wait, and the log names who was in the way.
#[test]
fn patience_ends_a_mission_whose_processes_cannot_join() {
    let mut mission = Mission::new("stopped-for-good");
    let (mut run, lock) = held_up(&mission, "5s");
    assert_eq!(run.code(), 1, "{}", run.log());
    let log = run.log();
    let told = format!("hopper-sim could not join for 5s: in its way is process {} (", std::process::id());
    assert!(log.contains(&told), "{log}");
    drop(lock);
    mission.assert_nothing_left();
}

/// P-HOLD-UP. A process that is in the way before the mission begins is waited for equally long.
#[test]
fn a_mission_begins_once_nobody_is_in_the_way() {
    let mut mission = Mission::new("stopped-before");
    // The lock of whoever cleans up, which this very test holds.
    let held = mission.instance();
    std::fs::DirBuilder::new().mode(0o700).create(held.root()).unwrap();
    let lock = std::fs::File::create(held.root().join("presence.lock")).unwrap();
    flock(&lock, FlockOperation::LockExclusive).unwrap();
    let name = mission.name.as_str();
    let mut command = mission.hopper(&["run", "--instance", name, "--out", ".", "--patience", "10m"]);
    command.args(["--seed", "8", "--format", "json"]);
    let mut run = Process::spawn("run", command, &mission.path(""));
    run.await_log(&format!("process {} (", std::process::id()));
    // Longer than was once waited.
    std::thread::sleep(Duration::from_secs(6));
    assert!(run.has_ended().is_none(), "{}", run.log());
    drop(lock);
    assert_eq!(run.code(), 0, "{}", run.log());
    mission.assert_nothing_left();
}

/// P-LEFT-OUT: A monitor that was stopped until hopper-sim had left says how many decisions it lacks
/// and where they are: its exit code is 4.
#[test]
fn a_monitor_that_reads_again_after_the_end_says_what_it_lacks() {
    let mut mission = Mission::new("stopped-monitor");
    let (_, patrol) = scenario::BUILT_IN.into_iter().find(|(name, _)| *name == "patrol").unwrap();
    let text = patrol.replace("hops_max = 1000000", "hops_max = 600");
    std::fs::write(mission.path("patrol.toml"), text).unwrap();
    let mut sim = mission.start("sim", &["--seed", "2", "--scenario", "patrol.toml", "--pace", "max"]);
    let mut perception = mission.start("perception", &[]);
    let mut monitor = mission.start("monitor", &["--format", "json"]);
    monitor.await_log("hop 0");
    monitor.signal(Signal::STOP);
    let mut planner = mission.start("planner", &[]);
    for process in [&mut sim, &mut perception, &mut planner] {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
    monitor.signal(Signal::CONT);
    assert_eq!(monitor.code(), 4, "{}", monitor.log());
    let (seen, flown) = (monitor.json(), &sim.json()["decisions"]);
    let lacks = format!("it lacks {} of {flown} decisions", seen["missing"]);
    assert!(seen["missing"].as_u64().unwrap() > 0 && monitor.log().contains(&lacks), "{}", monitor.log());
    mission.assert_nothing_left();
}
