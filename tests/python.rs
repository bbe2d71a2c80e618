//! The Python package: built as a user builds it, in a virtual environment, and flown.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::harness::{self, Mission, Process, json, stderr};
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What the tests need besides the package, and what builds it.
const REQUIREMENTS: &str = "maturin>=1.9.4,<2 numpy>=1.26 gymnasium>=1.0 pettingzoo>=1.24 quantecon==0.11.4 matplotlib>=3.8 \
                            nbclient>=0.10 ipykernel>=6";

/// The interpreter of a virtual environment in the target folder, with the package as it is now.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-venv");
        let (interpreter, stamp) = (folder.join("bin/python"), folder.join("requirements.txt"));
        let does = |command: &mut Command, what: &str| {
            let output =
                command.output().unwrap_or_else(|error| panic!("{what} needs python3 with venv: {error}"));
            assert!(output.status.success(), "{what} failed; it needs PyPI once:\n{}", stderr(&output));
        };
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        if std::fs::read_to_string(&stamp).ok().as_deref() != Some(REQUIREMENTS) {
            let mut venv = Command::new("python3");
            does(venv.args(["-m", "venv", "--clear"]).arg(&folder), "making a virtual environment");
            let mut install = Command::new(&interpreter);
            does(install.args(pip).args(REQUIREMENTS.split(' ')), "installing from PyPI");
            std::fs::write(&stamp, REQUIREMENTS).unwrap();
        }
        let mut install = Command::new(&interpreter);
        install
            .args(pip)
            .args(["--no-build-isolation", "--no-deps", "--force-reinstall"])
            .arg(root().join("python"));
        // Compiled for these tests alone: a little optimised takes half as long.
        install.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1");
        // maturin is a program of the environment.
        let path = std::env::var("PATH").unwrap_or_default();
        install.env("PATH", format!("{}:{path}", folder.join("bin").display()));
        does(&mut install, "pip install ./python");
        interpreter
    })
}

/// Runs a script of `python/tests`.
fn script(name: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(python());
    command.arg(root().join("python/tests").join(name)).args(arguments).env_remove("HOPPER_INSTANCE");
    command
}

/// What a script prints.
fn told(name: &str, arguments: &[&str]) -> Value {
    let output = script(name, arguments).output().unwrap();
    assert!(output.status.success(), "{name}: {}", stderr(&output));
    json(&output)
}

fn templates() -> String {
    root().join("templates").display().to_string()
}

/// Starts the template's planner in the instance of `mission`.
fn template(mission: &Mission) -> Process {
    let mut command = Command::new(python());
    command.arg(root().join("templates/planner_python.py")).env("HOPPER_INSTANCE", &mission.name);
    Process::spawn("planner", command, &mission.path(""))
}

/// P-PYTHON: A planner of 20 lines of Python, killed and restarted in a live mission, has the
/// digest of the same planner in lockstep. Its arrays are read-only and hold what has been seen;
/// the solver agrees with value iteration within its bound.
/// P-PYTHON-OWN: `hopper.run` without a planner flies those that the scenario names, with the
/// digest of the command line.
/// P-OWN-UNSUITED. A Python planner that does not suit a mission is refused by name.
#[test]
fn a_python_planner_flies_live_as_in_lockstep() {
    if suites::is_left_out("python") {
        return;
    }
    let lines = std::fs::read_to_string(root().join("templates/planner_python.py")).unwrap();
    assert!(lines.lines().count() <= 20);
    let mission = Mission::new("python");
    let digests = told("check.py", &[&templates(), &mission.name]);
    assert_eq!(digests["mdp"], harness::lockstep(&["--seed", "3"])["digest"]);
    for (scenario, digest) in digests["own"].as_object().unwrap() {
        assert_eq!(*digest, harness::lockstep(&["--scenario", scenario])["digest"], "{scenario}");
    }

    let slow = mission.start_slow_sim("3");
    let mut peers = ["perception", "monitor"].map(|role| mission.start(role, &[]));
    let mut planner = template(&mission);
    mission.await_decisions(2);
    planner.kill();
    planner = template(&mission);
    planner.await_log("in command");
    let sim = mission.hurry(slow, "3");
    assert_eq!(sim.json()["digest"], digests["template"]);
    for process in peers.iter_mut().chain([&mut planner]) {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
    let verified = mission.verified();
    assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()));
}

/// P-PYTHON-HOSTILE: Invalid arguments to every function, method and property of the Python package
/// raise an `Exception` before anything moves, and pipes and devices are not waited for. No planner
/// can make the arrays that it is given writable.
#[test]
fn hostile_arguments_are_refused_and_nothing_moves() {
    if suites::is_left_out("python") {
        return;
    }
    let calls = told("check_hostile.py", &[])["calls"].as_u64().unwrap();
    assert!(calls > 5000, "{calls} calls");
}

/// P-PYTHON-THREADS: Environments, missions and the solver of the Python package work in any
/// thread, several at once, and in forked children; Ctrl-C ends them.
#[test]
fn everything_works_in_any_thread_and_in_forked_children() {
    if suites::is_left_out("python") {
        return;
    }
    told("check_threads.py", &[&templates()]);
}

/// P-PYTHON-COPIES: Copies and pickles of environments, and environments restored from a snapshot,
/// continue as the originals do and affect only themselves. All missions of an environment use the
/// ground that it was made with, whatever happens to its files and the working directory, or are
/// refused.
#[test]
fn copies_pickles_and_snapshots_go_on_as_the_environment_does() {
    if suites::is_left_out("python") {
        return;
    }
    told("check_copies.py", &[]);
}

/// P-PYTHON-NOTEBOOK: The notebook of the examples runs from top to bottom and shows its pictures.
#[test]
fn the_notebook_runs_from_top_to_bottom() {
    if suites::is_left_out("python") {
        return;
    }
    let notebook = root().join("python/examples/first_missions.ipynb");
    let shown = told("run_notebook.py", &[&notebook.to_string_lossy()]);
    assert_eq!((&shown["svg"], &shown["png"]), (&1.into(), &3.into()));
}

/// P-PYTHON-FORK: A child that a planner forks within `decide` ends with an error when it returns,
/// and the mission continues with the parent.
#[test]
fn a_child_that_comes_back_from_decide_ends_and_the_mission_goes_on() {
    if suites::is_left_out("python") {
        return;
    }
    let mut mission = Mission::new("fork");
    let planner = root().join("python/tests/fork_planner.py");
    let command = format!("'{}' '{}' '{}'", python().display(), planner.display(), templates());
    let output = mission.fly(&["--planner-command", &command, "--seed", "3"]);
    let (summary, log) = (json(&output), stderr(&output));
    assert_eq!(summary["outcome"], "goal", "{summary}");
    for need in ["got a fork of it that came back from decide", "the child ended with 7"] {
        assert!(log.contains(need), "no {need:?}: {log}");
    }
    mission.assert_nothing_left();
}

/// P-QUANTECON: `hopper.solve` agrees with quantecon's policy iteration within its bound, on random
/// worlds with slopes, sand and lost ground.
#[test]
fn the_solver_agrees_with_quantecon() {
    if suites::is_left_out("python") {
        return;
    }
    let read = told("check_quantecon.py", &[]);
    let count = |name: &str| read[name].as_u64().unwrap();
    // Where two hops are worth the same, either is right.
    assert!(count("worlds") == 20 && count("equal_hops") * 100 >= count("cells") * 99, "{read}");
}

/// P-PYTHON-HOLD: Exceptions, wrong types and time-outs in `decide` cause a message and a hold; no
/// decision is lost, and journal and recording can be read.
#[test]
fn what_goes_wrong_in_decide_is_a_message_and_a_hold() {
    if suites::is_left_out("python") {
        return;
    }
    let mut mission = Mission::new("python");
    let faulty = root().join("python/tests/faulty_planner.py");
    let command = format!("'{}' '{}' '{}'", python().display(), faulty.display(), templates());
    let output = mission.fly(&["--planner-command", &command, "--seed", "3", "--record", "faulty.mcap"]);
    let log = stderr(&output);
    let summary = json(&output);
    for need in [
        "ValueError: a mistake of decision 1",
        "decide raised an exception at decision 1: holding",
        "decision 2: decide needs to return a hopper.Action, here HOLD or a hop, got 'north' of type str: holding",
        "decision 3: decide needs to return a hopper.Action, here HOLD or a hop, got None of type NoneType: holding",
        "decision 4: decide needs to return a hopper.Action, here HOLD or a hop, got <Action.STEP_EAST: 6>",
        "decide needs to answer within 3s, and has not at decision 5: holding",
        "DecideTimeout",
        "decide keeps arrays of the map",
    ] {
        assert!(log.contains(need), "no {need:?}: {log}");
    }
    assert_eq!(summary["planners"].as_array().unwrap().len(), 1, "it never lost command: {summary}");
    let (out, recording) = (mission.path("out"), mission.path("faulty.mcap"));
    let read = told("read.py", &[&out.to_string_lossy(), &recording.to_string_lossy()]);
    assert_eq!(read["digest"], summary["digest"]);
    assert_eq!(read["decisions"], summary["decisions"]);
    let actions: Vec<u64> =
        read["actions"].as_array().unwrap().iter().map(|code| code.as_u64().unwrap()).collect();
    assert_eq!(actions[1..6], [0; 5], "holds");
    assert!(actions[0] != 0 && actions[6..].iter().all(|code| *code != 0), "{actions:?}");
    // A recorder that is slower than the mission misses some.
    let commands = read["commands"].as_array().unwrap();
    assert!(
        !commands.is_empty()
            && commands.iter().all(|decision| decision.as_u64().unwrap() < actions.len() as u64)
    );
    mission.assert_nothing_left();
}

/// P-GYM: The environment passes gymnasium's checker; its vector form agrees with single
/// environments and resets only those that `reset_mask` names; other options are refused; warnings
/// point to the calling line; its planes are the observed map; and the same seed and actions have
/// the digest of lockstep and of a live mission.
#[test]
fn an_environment_has_the_digest_of_the_live_mission() {
    if suites::is_left_out("python") {
        return;
    }
    let read = told("check_gym.py", &[]);
    let mut mission = Mission::new("gym");
    let replay = root().join("python/tests/replay_planner.py");
    let command = format!("'{}' '{}' '{}'", python().display(), replay.display(), read["actions"]);
    let summary = json(&mission.fly(&["--planner-command", &command, "--seed", "3"]));
    assert_eq!(summary["digest"], read["digest"]);
    mission.assert_nothing_left();
}

/// P-PETTINGZOO: The environment of several rovers passes pettingzoo's checks in both forms, turn
/// by turn and parallel, and the same actions have the digest of lockstep.
#[test]
fn an_environment_of_several_rovers_has_the_digest_of_lockstep() {
    if suites::is_left_out("python") {
        return;
    }
    let digests = told("check_pettingzoo.py", &[]);
    assert_ne!(digests[0], digests[1]);
}

/// P-LEARN: A learner in NumPy learns to cross `hard` from rewards alone.
#[test]
fn a_learner_in_numpy_learns_to_cross_hard_ground() {
    if suites::is_left_out("python") {
        return;
    }
    let output = Command::new(python()).arg(root().join("python/examples/learn.py")).output().unwrap();
    let learned = json(&output);
    let share = |name: &str| learned[name].as_f64().unwrap();
    assert!(share("first") < 0.7 && share("learned") > 0.95, "{learned}");
}

/// P-PYTHON-STOP: A signal interrupts a planner within `decide`, and no action is commanded that it
/// did not choose.
#[test]
fn a_signal_interrupts_decide_and_nothing_is_commanded() {
    if suites::is_left_out("python") {
        return;
    }
    let mission = Mission::new("stop");
    let mut sim = mission.start("sim", &["--seed", "3", "--pace", "50"]);
    let _peers = ["perception", "monitor"].map(|role| mission.start(role, &[]));
    let mut command = script("stuck_planner.py", &["2"]);
    command.env("HOPPER_INSTANCE", &mission.name);
    let mut planner = Process::spawn("planner", command, &mission.path(""));
    planner.await_log("stuck at decision 2");
    planner.signal(rustix::process::Signal::TERM);
    assert_eq!(planner.code(), 130, "{}", planner.log());
    assert_eq!(mission.decisions(), 2);
    let mut command = script("stuck_planner.py", &["1000"]);
    command.env("HOPPER_INSTANCE", &mission.name);
    let mut planner = Process::spawn("planner", command, &mission.path(""));
    sim.code();
    assert_eq!(planner.code(), 0, "{}", planner.log());
    let summary = sim.json();
    assert_eq!(summary["outcome"], "deadlock", "it holds: {summary}");
    assert_eq!(mission.verified()["duplicates"], 0);
}
