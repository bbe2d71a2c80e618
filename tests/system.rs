//! Four real processes fly a mission, however they are started and ended.

use crate::harness::{self, Mission, eventually, hopper, json, lockstep, stderr};
use rustix::process::Signal;

const ROLES: [&str; 4] = ["sim", "perception", "planner", "monitor"];

/// P-LOCKSTEP-MAPS: `journal verify --against-lockstep`, `--planners-from` and chaos compare the
/// map of every decision with lockstep's, not only the digest.
/// P-RUN: A mission of four processes has the digest of the same mission in lockstep, bit for bit,
/// and its summary has the fields that programs rely on.
#[test]
fn four_processes_have_the_digest_of_lockstep() {
    for (scenario, profile) in [("hard", "paper-2023"), ("sandy", "hopper")] {
        let words = ["--scenario", scenario, "--profile", profile, "--seed", "5"];
        let mut mission = Mission::new("run");
        let output = mission.fly(&words);
        let summary = json(&output);
        let undisturbed = lockstep(&words);
        assert_eq!(summary["digest"], undisturbed["digest"], "{}", stderr(&output));
        assert_eq!(summary["steps"], undisturbed["steps"]);
        mission.assert_as_lockstep("out/journal");
        assert_eq!(output.status.code(), Some(if summary["outcome"] == "goal" { 0 } else { 1 }));
        for field in ["scenario", "seed", "profile", "outcome", "steps", "hops", "digest", "artifacts"] {
            assert!(!summary[field].is_null(), "{field} is promised");
        }
        let planner = &summary["planners"][0];
        assert_eq!((&planner["name"], &planner["term"]), (&"mdp".into(), &1.into()));
        assert_eq!(planner["from_decision"], 0);
        let latency = &summary["latency"];
        assert_eq!(latency["budget_us"], 600_000.0);
        assert_eq!(latency["decisions"], summary["decisions"]);
        for stage in ["state", "sense", "map", "deliver", "plan", "command", "commit"] {
            assert!(latency["stages"][stage]["p50_us"].is_number(), "{stage}");
        }
        let roles: Vec<&str> = summary["processes"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|process| process["role"].as_str())
            .collect();
        assert_eq!(roles, ["hopper-sim", "perception", "planner", "monitor"]);
        assert!(mission.path("out/mission.svg").exists());
        assert!(mission.path("out/scenario.toml").exists());
        assert!(mission.path("out/provenance.json").exists());
        mission.assert_nothing_left();
    }
}

/// P-ORDER: The four processes may be started in any of the 24 orders.
#[test]
fn the_four_may_be_started_in_any_order() {
    let undisturbed = lockstep(&["--seed", "3"]);
    for order in permutations() {
        let mut mission = Mission::new("order");
        let mut processes = Vec::new();
        // The others could end the mission before a monitor comes.
        let is_watched_late = order[3] == "monitor";
        for role in order {
            let process = match (role, is_watched_late) {
                ("sim", true) => mission.start_slow_sim("3"),
                ("sim", false) => mission.start("sim", &["--seed", "3"]),
                _ => mission.start(role, &[]),
            };
            process.await_log("joined");
            processes.push(process);
        }
        if is_watched_late {
            let slow = processes.iter().position(|process| process.role == "sim").unwrap();
            let slow = processes.swap_remove(slow);
            processes.push(mission.hurry(slow, "3"));
        }
        for process in &mut processes {
            assert_eq!(process.code(), 0, "{order:?}: {}\n{}", process.role, process.log());
        }
        let sim = processes.iter().find(|process| process.role == "sim").unwrap();
        assert_eq!(sim.json()["digest"], undisturbed["digest"], "{order:?}");
        mission.assert_as_lockstep("journal");
        mission.assert_nothing_left();
    }
}

fn permutations() -> Vec<[&'static str; 4]> {
    let mut orders = Vec::new();
    for a in 0..4 {
        for b in (0..4).filter(|b| *b != a) {
            for c in (0..4).filter(|c| *c != a && *c != b) {
                orders.push([a, b, c, 6 - a - b - c].map(|index| ROLES[index]));
            }
        }
    }
    assert_eq!(orders.len(), 24);
    orders
}

/// P-INSTANCE: Two instances on one machine never meet.
#[test]
fn two_instances_never_meet() {
    let missions = [("1", Mission::new("apart")), ("2", Mission::new("apart"))];
    let mut processes: Vec<_> = missions
        .iter()
        .map(|(seed, mission)| {
            let mut processes = vec![mission.start("sim", &["--seed", seed, "--pace", "100"])];
            processes.extend(mission.start_peers());
            processes
        })
        .collect();
    for ((seed, _), processes) in missions.iter().zip(&mut processes) {
        assert_eq!(processes[0].code(), 0, "{}", processes[0].log());
        assert_eq!(processes[0].json()["digest"], lockstep(&["--seed", seed])["digest"]);
        let lives = processes[0].json()["processes"].as_array().unwrap().len();
        assert_eq!(lives, 4, "each hopper-sim hears its own four only");
    }
}

/// P-ONE-SIM: A second hopper-sim in an instance is refused, and the error names the process that
/// holds the instance.
#[test]
fn a_second_hopper_sim_is_refused_naming_the_holder() {
    let mission = Mission::new("second");
    let first = mission.start("sim", &[]);
    first.await_log("joined");
    let mut second = mission.start("sim", &["--journal", "other"]);
    assert_eq!(second.code(), 4, "{}", second.log());
    assert!(second.log().contains(&first.pid().to_string()), "{}", second.log());
}

/// P-WAIT: A process that waits in vain exits with code 4 and names the peer it waited for.
#[test]
fn a_process_that_waits_in_vain_gives_up_naming_whom_it_waited_for() {
    for (role, whom) in [("perception", "hopper-sim"), ("planner", "hopper-sim"), ("monitor", "hopper-sim")] {
        let mission = Mission::new("vain");
        let mut process = mission.start(role, &["--wait", "300ms"]);
        assert_eq!(process.code(), 4, "{}", process.log());
        assert!(process.log().contains(whom), "{}", process.log());
    }
    let mission = Mission::new("vain");
    let mut sim = mission.start("sim", &["--wait", "300ms"]);
    assert_eq!(sim.code(), 4, "{}", sim.log());
    assert!(sim.log().contains("perception"), "{}", sim.log());
}

/// P-STAY: A peer started with `--stay` serves the next mission too.
#[test]
fn peers_that_stay_serve_the_next_mission() {
    let mission = Mission::new("stay");
    let mut peers: Vec<_> =
        ["perception", "planner", "monitor"].map(|role| mission.start(role, &["--stay"])).into();
    for (seed, journal) in [("1", "first"), ("2", "second")] {
        let mut sim = mission.start("sim", &["--seed", seed, "--journal", journal]);
        assert_eq!(sim.code(), 0, "{}", sim.log());
        assert_eq!(sim.json()["digest"], lockstep(&["--seed", seed])["digest"]);
    }
    for peer in &mut peers {
        assert!(peer.has_ended().is_none(), "{} left: {}", peer.role, peer.log());
        peer.signal(Signal::INT);
        assert_eq!(peer.code(), 130, "{}", peer.log());
    }
}

/// P-HOLD: Standing still is a decision that costs a step.
#[test]
fn a_hopper_that_never_moves_ends_in_deadlock() {
    let mut mission = Mission::new("hold");
    let output = mission.fly(&["--planner", "hold"]);
    let summary = json(&output);
    assert_eq!(summary["outcome"], "deadlock");
    assert_eq!((&summary["hops"], &summary["decisions"]), (&0.into(), &150.into()));
    assert_eq!(output.status.code(), Some(1));
    mission.assert_nothing_left();
}

/// P-INTERRUPT: An interrupted run leaves no process and no shared memory, and resumes to the
/// digest of an undisturbed run.
#[test]
fn an_interrupted_run_leaves_nothing_and_resumes() {
    let mut mission = Mission::new("interrupt");
    let name = mission.name.clone();
    let run = ["--instance", &name, "--out", ".", "--format", "json", "--seed", "4"];
    let mut command = mission.hopper(&["run"]);
    command.args(run).args(["--pace", "0.5"]);
    let mut first = harness::Process::spawn("run", command, &mission.path(""));
    mission.await_decisions(2);
    let children = children_of(first.pid());
    assert_eq!(children.len(), 4);
    first.signal(Signal::TERM);
    assert_eq!(first.code(), 130, "{}", first.log());
    assert_eq!(first.json()["outcome"], "stopped");
    assert!(children.iter().all(|pid| !lives(*pid)), "{}", first.log());
    mission.assert_nothing_left();

    let output = mission.hopper(&["run"]).args(run).output().unwrap();
    let summary = json(&output);
    assert_eq!(summary["digest"], lockstep(&["--seed", "4"])["digest"]);
    mission.assert_nothing_left();
}

/// P-LIFELINE: If `hopper run` is killed outright, none of its child processes stays.
#[test]
fn a_run_that_is_killed_outright_leaves_no_child() {
    let mission = Mission::new("outright");
    let mut command = mission.hopper(&["run", "--instance", &mission.name, "--out", ".", "--pace", "0.5"]);
    command.args(["--seed", "4"]);
    let mut run = harness::Process::spawn("run", command, &mission.path(""));
    mission.await_decisions(2);
    let children = children_of(run.pid());
    assert_eq!(children.len(), 4);
    run.kill();
    eventually("the children to end", || children.iter().all(|pid| !lives(*pid)));
}

fn children_of(parent: u32) -> Vec<u32> {
    let tasks = std::fs::read_dir(format!("/proc/{parent}/task")).unwrap();
    tasks
        .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("children")).ok())
        .flat_map(|text| text.split_whitespace().filter_map(|pid| pid.parse().ok()).collect::<Vec<u32>>())
        .collect()
}

/// Whether a process runs; a corpse that nobody has buried yet does not.
fn lives(pid: u32) -> bool {
    std::fs::read_to_string(format!("/proc/{pid}/stat"))
        .is_ok_and(|stat| !stat.rsplit(')').next().unwrap_or("").trim_start().starts_with('Z'))
}

/// P-LOCKSTEP: Lockstep needs no instance, and ignores one named by the environment.
#[test]
fn lockstep_minds_no_instance() {
    let dir = tempfile::tempdir().unwrap();
    let mut command =
        hopper(&["run", "--lockstep", "--format", "json", "--out", dir.path().to_str().unwrap()]);
    let output = command.env("HOPPER_INSTANCE", "somebody").output().unwrap();
    assert_eq!(json(&output)["digest"], lockstep(&[])["digest"]);
}
