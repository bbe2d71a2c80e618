//! Processes die at every named point and at random, and the mission ends with the undisturbed digest.

use std::fs;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::Path;
use std::time::Duration;

use crate::harness::{self, Mission, Process, lockstep, stderr};
use rustix::fs::{FlockOperation, flock};
use rustix::process::Signal;
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
    mission.assert_as_lockstep("journal");
    (processes[0].json(), deaths)
}

/// P-CRASH-POINTS: kill -9 of any role at any named crash point leaves the digest unchanged.
#[test]
fn a_death_at_any_named_point_leaves_the_digest() {
    let undisturbed = lockstep(&["--seed", "21"]);
    let points = [
        ("sim", hopper_sim::CRASH_POINTS),
        ("perception", perception::process::CRASH_POINTS),
        ("planner", planner::process::CRASH_POINTS),
        ("monitor", monitor::process::CRASH_POINTS),
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

/// P-KILL: kill -9 of any role at random moments leaves the digest unchanged.
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
        mission.assert_as_lockstep("journal");
        let verified = mission.verified();
        assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()), "{victim}");
    }
}

/// `hopper doctor WORDS` of the mission's instance: it must do.
fn doctor(mission: &Mission, words: &[&str]) -> Value {
    let output = mission
        .hopper(&["doctor", "--instance", &mission.name, "--format", "json"])
        .args(words)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    harness::json(&output)
}

/// What `doctor` tells of as left over, `doctor --clean` removes.
fn assert_repaired(mission: &Mission, state: &str) {
    let told = doctor(mission, &[]);
    let left = told["instances"][0]["leftovers"].as_array().unwrap();
    assert_eq!(left.is_empty(), mission.instance().paths().unwrap().is_empty(), "{state}: {told}");
    let cleaned = doctor(mission, &["--clean"]);
    assert_ne!(cleaned["cleaned"][0]["outcome"], "alive", "{state}");
    assert_eq!(mission.instance().paths().unwrap(), [] as [std::path::PathBuf; 0], "{state}");
}

/// Kills all there are, and has what they left repaired.
fn assert_killed_and_repaired(mission: &Mission, mut processes: Vec<Process>, state: &str) {
    processes.iter_mut().for_each(Process::kill);
    drop(processes);
    assert_repaired(mission, state);
}

/// P-REPAIR: `doctor --clean` repairs every state that killed processes leave behind, including
/// half-made and damaged files.
#[test]
fn the_doctor_repairs_every_state_that_the_dead_leave_behind() {
    let mut mission = Mission::new("repair");
    let start = |crash: &str| {
        let start =
            |role: &&str| mission.start_with(role, &words(role, "24", "200"), &[("HOPPER_CRASH", crash)]);
        ROLES.iter().map(start).collect::<Vec<_>>()
    };
    // Everybody at once, ever later in the start.
    for step in 0..12 {
        let processes = start("");
        std::thread::sleep(Duration::from_millis(step * 3));
        assert_killed_and_repaired(&mission, processes, &format!("start-up, {} ms", step * 3));
        let _ = fs::remove_dir_all(mission.journal());
    }
    // One at its crash point, then the others.
    let points = [
        hopper_sim::CRASH_POINTS,
        perception::process::CRASH_POINTS,
        planner::process::CRASH_POINTS,
        monitor::process::CRASH_POINTS,
    ];
    for (victim, points) in points.into_iter().enumerate() {
        for point in points {
            let mut processes = start(point);
            harness::eventually(point, || processes[victim].has_ended().is_some());
            assert_killed_and_repaired(&mission, processes, point);
            let _ = fs::remove_dir_all(mission.journal());
        }
    }
    for (state, make) in DAMAGE {
        let mut processes = start("");
        mission.await_decisions(2);
        processes.iter_mut().for_each(Process::kill);
        drop(processes);
        make(&mission);
        assert_repaired(&mission, state);
        let _ = fs::remove_dir_all(mission.journal());
    }
    let name = mission.name.clone();
    let fly = ["run", "--instance", &name, "--out", ".", "--seed", "24", "--format", "json"];
    let output = mission.hopper(&fly).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(harness::json(&output)["digest"], lockstep(&["--seed", "24"])["digest"]);
    mission.assert_nothing_left();
}

type Damage = (&'static str, fn(&Mission));

/// States that no death is sure to leave, made by hand.
const DAMAGE: &[Damage] = &[
    ("no label", |mission| fs::remove_file(mission.instance().root().join("instance")).unwrap()),
    ("half a label", |mission| write(&mission.instance().root().join("instance.17"), 0o600)),
    ("no lock", |mission| fs::remove_file(mission.instance().root().join("presence.lock")).unwrap()),
    ("no folder", |mission| fs::remove_dir_all(mission.instance().root()).unwrap()),
    ("an empty folder", |mission| {
        let root = mission.instance().root().to_path_buf();
        mission.instance().clean().unwrap();
        fs::DirBuilder::new().mode(0o700).create(root).unwrap();
    }),
    ("half-made files", |mission| {
        let root = mission.instance().root().to_path_buf();
        let tag = root.file_name().unwrap().to_str().unwrap();
        write(&root.with_file_name(format!("{tag}_0123456789.data")), 0o200);
        write(&root.with_file_name(format!("{tag}_0_1.connection")), 0o200);
        write(&root.join("services").join("half.service"), 0o600);
        write(&root.join("nodes").join(format!("{tag}_1.node_monitor_context")), 0o200);
    }),
    ("damaged files", |mission| {
        for path in files(mission.instance().root()) {
            fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o600)).unwrap();
            fs::write(&path, b"no such thing").unwrap();
        }
    }),
    ("no services", |mission| fs::remove_dir_all(mission.instance().root().join("services")).unwrap()),
];

fn write(path: &Path, mode: u32) {
    fs::OpenOptions::new().write(true).create(true).truncate(true).mode(mode).open(path).unwrap();
}

/// Plain files below `folder`.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        match entry.file_type().unwrap() {
            kind if kind.is_dir() => files.extend(self::files(&entry.path())),
            kind if kind.is_file() => files.push(entry.path()),
            _ => {}
        }
    }
    files
}

/// P-REPAIR-LIVE: `doctor --clean` touches nothing of an instance whose processes are all stopped
/// but alive.
#[test]
fn the_doctor_leaves_the_stopped_alone() {
    let mission = Mission::new("stopped");
    let mut processes = vec![mission.start_slow_sim("25")];
    processes.extend(mission.start_peers());
    mission.await_decisions(1);
    let creation_lock = fs::File::open(mission.instance().root().join("creation.lock")).unwrap();
    // Who is stopped with the lock of those who make things keeps out the doctor too.
    harness::eventually("all to be stopped with nothing half-made", || {
        processes.iter().for_each(|process| process.signal(Signal::STOP));
        std::thread::sleep(Duration::from_millis(5));
        let free = flock(&creation_lock, FlockOperation::NonBlockingLockExclusive).is_ok();
        if !free {
            processes.iter().for_each(|process| process.signal(Signal::CONT));
        }
        flock(&creation_lock, FlockOperation::Unlock).unwrap();
        free
    });
    let before = mission.instance().paths().unwrap();
    assert_eq!(doctor(&mission, &["--clean"])["cleaned"][0]["outcome"], "alive");
    assert_eq!(mission.instance().paths().unwrap(), before);
    processes.iter().for_each(|process| process.signal(Signal::CONT));
    let sim = mission.hurry(processes.remove(0), "25");
    assert_eq!(sim.json()["digest"], lockstep(&["--seed", "25"])["digest"]);
    processes.iter_mut().for_each(|peer| assert_eq!(peer.code(), 0, "{}", peer.log()));
}

/// P-RESTART: `hopper run` restarts any process that dies, without limit in the long run: only six
/// deaths of one process within two minutes are too many.
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
        slow.kill_child(role);
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

/// P-GIVE-UP: `hopper run` stops restarting a planner that crashes in a loop, and the hopper holds.
#[test]
fn a_crash_looping_planner_is_given_up_and_the_hopper_holds() {
    let mut mission = Mission::new("loop");
    let name = mission.name.clone();
    let mut command = mission.hopper(&["run", "--instance", &name, "--out", ".", "--patience", "1s"]);
    // It has the map, be it from patches or pages, and dies before it has commanded.
    command.env("HOPPER_CRASH", "planner.planned");
    let mut run = Process::spawn("run", command, &mission.path(""));
    assert_eq!(run.code(), 1, "{}", run.log());
    let told = run.log().matches("the hopper holds").count();
    assert_eq!(told, 1, "{}", run.log());
    assert_eq!(mission.verified()["decisions"], 0, "no hop without a planner");
    mission.assert_nothing_left();
}

/// P-WATCHER: `hopper run` stops restarting a monitor that keeps crashing, and the mission
/// continues.
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
