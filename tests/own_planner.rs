//! Planners from outside the workspace: a crate of one's own, and any program in place of the built-in process.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::harness::{self, Mission, Process, json, stderr};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The program of `templates/planner-rust`, copied to an empty folder, tested and built there.
fn template() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let template = root().join("templates/planner-rust");
        std::fs::create_dir(folder.path().join("src")).unwrap();
        std::fs::copy(template.join("src/main.rs"), folder.path().join("src/main.rs")).unwrap();
        let manifest = std::fs::read_to_string(template.join("Cargo.toml")).unwrap();
        let here = format!("path = {:?}", root().join("planner"));
        assert!(manifest.contains("path = \"../../planner\""), "{manifest}");
        let manifest = manifest.replace("path = \"../../planner\"", &here);
        let ours = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
        let (_, profile) = ours.split_once("[profile.dev]\n").unwrap();
        let (profile, _) = profile.split_once("[profile.release]\n").unwrap();
        let manifest = format!("{manifest}\n[profile.dev]\n{profile}");
        std::fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
        // The same releases of all dependencies, which are downloaded already.
        std::fs::copy(root().join("Cargo.lock"), folder.path().join("Cargo.lock")).unwrap();
        // They are compiled already where these tests are built in the same profile, which the template takes over.
        let test = std::env::current_exe().unwrap();
        let target = test.ancestors().nth(3).unwrap();
        for command in ["build", "test"] {
            let mut cargo = Command::new(env!("CARGO"));
            cargo.args([command, "--quiet", "--offline", "--target-dir"]).arg(target);
            let output = cargo.current_dir(folder.path()).output().unwrap();
            assert!(output.status.success(), "{}", stderr(&output));
        }
        target.join("debug/my-planner")
    })
}

/// Starts the template's planner in the instance of `mission`.
fn start(mission: &Mission) -> Process {
    let mut command = Command::new(template());
    command.args(["--instance", &mission.name]).env_remove("HOPPER_INSTANCE");
    Process::spawn("planner", command, &mission.path(""))
}

/// P-TEMPLATE: A crate of 40 lines outside the workspace is a planner process: it passes the
/// conformance check, may be killed and restarted, and the digest is that of the undisturbed
/// mission.
#[test]
fn a_crate_outside_the_workspace_is_a_planner_process() {
    if suites::is_left_out("own planner") {
        return;
    }
    let lines = std::fs::read_to_string(root().join("templates/planner-rust/src/main.rs")).unwrap();
    assert!(lines.lines().count() <= 40);
    let fly = |kills: bool| {
        let mut mission = Mission::new("template");
        let pace = if kills { "0.5" } else { "max" };
        let mut sim = mission.start("sim", &["--seed", "3", "--pace", pace]);
        let mut peers = ["perception", "monitor"].map(|role| mission.start(role, &[]));
        let mut planner = start(&mission);
        if kills {
            mission.await_decisions(2);
            planner.kill();
            planner = start(&mission);
            planner.await_log("in command");
            sim = mission.hurry(sim, "3");
        }
        sim.code();
        let summary = sim.json();
        for process in peers.iter_mut().chain([&mut planner]) {
            assert_eq!(process.code(), 0, "{}", process.log());
        }
        let verified = mission.verified();
        assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()));
        let planners = summary["planners"].as_array().unwrap();
        assert!(planners.iter().all(|planner| planner["name"] == "my_planner"), "{summary}");
        if !kills {
            mission.assert_nothing_left();
        }
        summary["digest"].clone()
    };
    assert_eq!(fly(true), fly(false));
}

/// `hopper run --planner-command COMMAND` with further `words`.
fn run(mission: &Mission, command: &str, words: &[&str]) -> Command {
    let mut run = mission.hopper(&["run", "--instance", &mission.name, "--out", "out", "--format", "json"]);
    run.args(["--planner-command", command]).args(words);
    run
}

/// A planner process as a program of its own.
fn greedy() -> String {
    format!("'{}' planner --algorithm greedy", harness::program("hopper").display())
}

/// P-PLANNER-COMMAND: `hopper run --planner-command` starts, watches and restarts a program in
/// place of the built-in planner, and says what is wrong with a program that does not exist, ends
/// at once, never joins or never commands.
#[test]
fn a_program_of_ones_own_is_started_watched_and_restarted() {
    let words = ["--seed", "6", "--planner", "greedy"];
    let undisturbed = harness::lockstep(&words);
    let mut mission = Mission::new("command");
    let output = run(&mission, &format!("sh -c \"{}; true\"", greedy()), &["--seed", "6"]).output().unwrap();
    let summary = json(&output);
    assert_eq!(summary["digest"], undisturbed["digest"], "{}", stderr(&output));
    assert_eq!(summary["processes"].as_array().unwrap().len(), 4, "the shell's child is no guest: {summary}");
    mission.assert_nothing_left();

    let mission = Mission::new("command");
    let slow = run(&mission, &greedy(), &["--seed", "6", "--pace", "2"]);
    let mut slow = Process::spawn("run", slow, &mission.path(""));
    let folder = mission.path("out/journal");
    let decisions =
        || folder.exists().then(|| harness::verify(&folder)["decisions"].as_u64()).flatten().unwrap_or(0);
    harness::eventually("two decisions", || decisions() >= 2);
    slow.kill_child("planner");
    slow.await_log("restarting it");
    let before = decisions();
    harness::eventually("another decision", || decisions() > before);
    slow.signal(rustix::process::Signal::TERM);
    assert_eq!(slow.code(), 130, "{}", slow.log());
    let output = run(&mission, &greedy(), &["--seed", "6"]).output().unwrap();
    assert_eq!(json(&output)["digest"], undisturbed["digest"], "{}", stderr(&output));
}

/// P-PLANNER-COMMAND. A path that is not a program, or a program that is not a planner, ends the
/// mission with an error that says what is needed.
#[test]
fn a_program_that_is_no_planner_is_refused_by_name() {
    let stranger = format!("{} --robot 1", greedy());
    for (command, patience, need) in [
        ("no-such-program-at-all", "60s", "is in no folder of PATH"),
        ("./planner.py", "60s", "does not exist"),
        ("'a", "60s", "needs another '"),
        ("true", "60s", "ended with exit status: 0 before it joined"),
        ("sh -c 'echo no such module; exit 1'", "60s", "ended with exit status: 1 before it joined"),
        ("sleep 600", "2s", "has not joined within 2s"),
        (&stranger, "60s", "joined and cannot plan for robot 0 of this mission"),
    ] {
        let mut mission = Mission::new("none");
        let output = run(&mission, command, &["--patience", patience]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{command}: {}", stderr(&output));
        assert!(stderr(&output).contains(need), "{command}: {}", stderr(&output));
        assert!(
            !mission.path("out/journal").exists(),
            "{command}: a mission that never began leaves no journal"
        );
        mission.assert_nothing_left();
    }
}
