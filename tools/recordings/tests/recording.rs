//! Recordings of real missions: made by the monitor, read by others, replayed, and measured.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../tests/harness/mod.rs"]
mod harness;
#[path = "recording/python.rs"]
mod python;

use std::process::Output;
use std::time::Duration;

use harness::{Mission, hopper, json, lockstep, stderr};
use serde_json::Value;

/// How long mcap, of less than a megabyte, may take to install.
const PYPI: Duration = Duration::from_secs(600);

/// Flies the mission by `hopper run --record FILE WORDS`; its summary.
fn flown(mission: &Mission, file: &str, words: &[&str]) -> Value {
    let out = format!("out-{file}");
    let mut command =
        mission.hopper(&["run", "--instance", &mission.name, "--format", "json", "--out", &out]);
    let output = command.args(["--record", file]).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    json(&output)
}

/// `hopper bag WORDS FILE`.
fn bag(mission: &Mission, words: &[&str], file: &str) -> Output {
    mission.hopper(&["bag"]).args(words).arg(file).output().unwrap()
}

/// `hopper bag info`, and its exit code.
fn info(mission: &Mission, file: &str) -> (Value, Option<i32>) {
    let output = bag(mission, &["info", "--format", "json"], file);
    (json(&output), output.status.code())
}

fn count(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no count"))
}

/// P-BAG: A recording of `hopper run` has every decision, the scenario, the seed, and the journal's
/// digest.
/// P-BAG-REPLAY: On replay, the planner that flew takes every decision as it did, on maps with the
/// same fingerprints; the differences of another planner are reported.
#[test]
fn a_recording_has_every_decision_and_its_planner_decides_them_again() {
    let mission = Mission::new("bag");
    let summary = flown(&mission, "a.mcap", &["--seed", "7", "--pace", "40"]);
    let (told, code) = info(&mission, "a.mcap");
    assert_eq!(code, Some(0), "{told}");
    assert_eq!((&told["whole"], &told["seed"], &told["status"]), (&true.into(), &"7".into(), &"goal".into()));
    assert_eq!((&told["digest"], &told["digest_at_end"]), (&summary["digest"], &summary["digest"]));
    assert_eq!((&told["decisions"], &told["records"]), (&summary["decisions"], &summary["decisions"]));
    assert_eq!(told["metadata"]["hopper"]["pace"], "40");
    let scenario = bag(&mission, &["info", "--scenario"], "a.mcap");
    let kept = std::fs::read(mission.path("out-a.mcap/scenario.toml")).unwrap();
    assert_eq!(scenario.stdout, kept, "the scenario is kept whole");

    let again = json(&bag(&mission, &["replay", "--format", "json"], "a.mcap"));
    assert_eq!((&again["planner"], &again["decisions"]), (&"mdp".into(), &summary["decisions"]));
    assert_eq!(
        (again["different"].as_array().unwrap().len(), &again["other_map"]),
        (0, &0.into()),
        "{again}"
    );
    assert_eq!(
        count(&again["compared"]) + count(&again["not_posed"]),
        count(&summary["decisions"]),
        "{again}"
    );
    if told["gaps"].as_array().unwrap().is_empty() {
        assert_eq!(again["not_posed"], 0, "{again}");
    }
    let greedy = json(&bag(&mission, &["replay", "--planner", "greedy", "--format", "json"], "a.mcap"));
    assert_eq!(greedy["compared"], again["compared"]);
    let different = greedy["different"].as_array().unwrap();
    assert!(!different.is_empty() && different.iter().all(|d| d["recorded"] != d["now"]), "{greedy}");
    let stepped = bag(&mission, &["replay", "--step"], "a.mcap");
    assert!(String::from_utf8_lossy(&stepped.stdout).contains("decided 0 of"), "no line, no decision");

    let rows = bag(&mission, &["export", "--format", "csv"], "a.mcap");
    let rows = String::from_utf8(rows.stdout).unwrap();
    assert!(rows.starts_with("decision,action,"), "{rows}");
    assert_eq!(rows.lines().count() as u64, 1 + count(&summary["decisions"]));
    let states = bag(&mission, &["export", "--topic", "hop/state"], "a.mcap");
    assert!(String::from_utf8_lossy(&states.stdout).lines().next().unwrap().contains("pose.cell.x"));
    // The mission waits for its recorder, so that it begins with the first of all messages.
    let states = bag(&mission, &["export", "--topic", "hop/state", "--format", "json"], "a.mcap");
    let first = String::from_utf8_lossy(&states.stdout).lines().next().map(str::to_owned).unwrap();
    assert!(first.contains(r#""decision":0,"#), "{first}");
}

/// P-LATENCY: Latency reports of recordings and of running instances have the journal's times;
/// missed deadlines give exit code 3.
#[test]
fn latency_is_reported_from_a_recording_and_from_a_running_instance() {
    let mission = Mission::new("latency");
    let summary = flown(&mission, "a.mcap", &["--seed", "3", "--pace", "100"]);
    flown(&mission, "b.mcap", &["--seed", "3", "--pace", "100"]);
    let report = |words: &[&str]| mission.hopper(&["latency", "report"]).args(words).output().unwrap();
    let loose =
        report(&["a.mcap", "--budget", "1h", "--format", "json", "--hgrm", "a.hgrm", "--svg", "a.svg"]);
    assert_eq!(loose.status.code(), Some(0), "{}", stderr(&loose));
    let told = json(&loose);
    assert_eq!((&told["decisions"], &told["misses"]), (&summary["decisions"], &0.into()));
    let (ours, theirs) = (&told["total"]["max_us"], &summary["latency"]["total"]["max_us"]);
    let ratio = ours.as_f64().unwrap() / theirs.as_f64().unwrap();
    assert!((ratio - 1.0).abs() < 0.01, "{ours} {theirs}");
    assert_eq!(told["worst"].as_array().unwrap().len(), 10);
    assert_eq!((&told["groups"][0]["planner"], &told["conditions"]["pace"]), (&"mdp".into(), &"100".into()));
    assert!(told["conditions"]["busy_mean"].is_number() && told["stages"]["plan"]["p99_9_us"].is_number());
    assert!(std::fs::read_to_string(mission.path("a.svg")).unwrap().ends_with("</svg>\n"));
    assert!(std::fs::read_to_string(mission.path("a.hgrm")).unwrap().contains("Total count"));
    assert_eq!(report(&["a.mcap", "--budget", "1ns"]).status.code(), Some(3));
    // The mission's own budget is told of, and no threshold was asked for.
    flown(&mission, "late.mcap", &["--seed", "3", "--budget", "1ns"]);
    let late = report(&["late.mcap", "--format", "json"]);
    assert_eq!((late.status.code(), json(&late)["misses"].as_u64() > Some(0)), (Some(0), true));
    let beside = json(&report(&["--compare", "a.mcap", "b.mcap", "--format", "json"]));
    assert_eq!(beside["differs"].as_array().unwrap().len(), 0, "{beside}");
    assert_eq!(beside["comparison"]["pairs"], summary["decisions"]);
    let p = beside["comparison"]["p"].as_f64().unwrap();
    assert!((0.0..=1.0).contains(&p), "{beside}");
    assert_eq!(report(&["nothing.mcap"]).status.code(), Some(2));
    flown(&mission, "c.mcap", &["--seed", "4", "--planner", "greedy"]);
    let unlike = report(&["--compare", "a.mcap", "c.mcap"]);
    let told = String::from_utf8(unlike.stdout).unwrap();
    for what in
        ["Warning: the seed of the first is 3, of the second 4", "Warning: the planner of the first is mdp"]
    {
        assert!(told.contains(what), "{told}");
    }

    let slow = mission.start_slow_sim("3");
    let peers = mission.start_peers();
    mission.await_decisions(2);
    let words = ["latency", "report", "--instance", &mission.name, "--budget", "1h", "--format", "json"];
    let living = mission.hopper(&words).output().unwrap();
    assert_eq!(living.status.code(), Some(0), "{}", stderr(&living));
    // The past tells a hop once it has landed.
    assert!(count(&json(&living)["decisions"]) >= 1);
    mission.hurry(slow, "3");
    drop(peers);
    let alone = ["latency", "report", "--instance", &mission.name, "--wait", "200ms"];
    assert_eq!(mission.hopper(&alone).output().unwrap().status.code(), Some(4));
}

/// P-LATENCY-DEAD: A long decision is explained by the perception or planner that was dead, and
/// then not by the map or the load of the host: in a recording that began before or while it was
/// dead, and in a report that begins when it is alive again.
#[test]
fn whoever_was_dead_is_named_as_the_cause() {
    let mission = Mission::new("dead");
    let words = ["--seed", "5", "--pace", "25", "--scenario", "patrol"];
    let mut sim = mission.start("sim", &words);
    let mut perception = mission.start("perception", &[]);
    let mut planner = mission.start("planner", &[]);
    let mut early = mission.start("monitor", &["--record", "early.mcap"]);
    let go_on = || mission.await_decisions(mission.decisions() + 8);
    let report = |words: &[&str]| {
        let output =
            mission.hopper(&["latency", "report", "--budget", "1h", "--format", "json"]).args(words).output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        json(&output)
    };
    let records = |file: &str| {
        let output = bag(&mission, &["info", "--format", "json"], file);
        if matches!(output.status.code(), Some(0 | 1)) { count(&json(&output)["records"]) } else { 0 }
    };
    harness::eventually("records in the first recording", || records("early.mcap") >= 8);
    perception.kill();
    perception = mission.start("perception", &[]);
    go_on();
    planner.kill();
    planner = mission.start("planner", &[]);
    go_on();
    sim.kill();
    sim = mission.start("sim", &words);
    go_on();
    perception.kill();
    let mut late = mission.start("monitor", &["--record", "late.mcap"]);
    harness::eventually("records in the second recording", || records("late.mcap") >= 8);
    let perception_again = mission.start("perception", &[]);
    go_on();
    let living = report(&["--instance", &mission.name]);
    for monitor in [&mut early, &mut late] {
        monitor.signal(rustix::process::Signal::TERM);
        monitor.code();
    }
    drop((sim, perception, perception_again, planner));
    // A resumed hopper-sim lands its hop anew, so no decision contains its restart.
    let all = ["perception restart", "planner restart"];
    for (report, need) in
        [(living, &all[..]), (report(&["early.mcap"]), &all[..]), (report(&["late.mcap"]), &all[..1])]
    {
        for cause in need {
            assert!(report["causes"][*cause][0].as_u64() > Some(0), "{cause} is not in {}", report["causes"]);
        }
        for worst in report["worst"].as_array().unwrap() {
            let causes = worst["causes"].to_string();
            assert!(
                !causes.contains("restart") || !causes.contains("host_load") && !causes.contains("snapshot"),
                "{worst}"
            );
        }
    }
}

/// P-BAG-KILL: A recording whose monitor was killed is readable, reported as cut, and recovered
/// with all its messages.
/// P-BAG-PYTHON: PyPI's `mcap` reads a whole recording, and a recovered one, to the same counts,
/// digests and cells.
#[test]
fn a_killed_recording_is_recovered_and_python_reads_both() {
    let mission = Mission::new("killed");
    let slow = mission.start("sim", &["--seed", "5", "--pace", "20", "--scenario", "patrol"]);
    let peers = ["perception", "planner"].map(|role| mission.start(role, &[]));
    let mut monitor = mission.start("monitor", &["--record", "killed.mcap", "--record-note", "seed=5"]);
    harness::eventually("records in the recording", || {
        // The file may not be there yet, or have no head yet.
        let output = bag(&mission, &["info", "--format", "json"], "killed.mcap");
        matches!(output.status.code(), Some(0 | 1)) && count(&json(&output)["records"]) >= 10
    });
    monitor.kill();
    // The next mission here is flown by its own.
    drop((slow, peers));
    let (cut, code) = info(&mission, "killed.mcap");
    assert_eq!((code, &cut["whole"], &cut["digest_at_end"]), (Some(1), &false.into(), &Value::Null), "{cut}");
    let refused = bag(&mission, &["recover", "killed.mcap"], "killed.mcap");
    assert_eq!(refused.status.code(), Some(2), "nothing is written over");
    let recovered = bag(&mission, &["recover", "killed.mcap"], "whole.mcap");
    assert_eq!(recovered.status.code(), Some(0), "{}", stderr(&recovered));
    let (whole, code) = info(&mission, "whole.mcap");
    assert_eq!((code, &whole["whole"], &whole["digest"]), (Some(0), &true.into(), &cut["digest"]));
    assert_eq!((&whole["topics"], &whole["gaps"]), (&cut["topics"], &cut["gaps"]));

    let summary = flown(&mission, "a.mcap", &["--seed", "7", "--pace", "40"]);
    let python = python::environment("mcap", PYPI)
        .unwrap_or_else(|why| panic!("this test reads recordings with mcap and needs PyPI once: {why}"));
    for file in ["whole.mcap", "a.mcap"] {
        let told = python::read(&python, "read.py", &mission.path(file));
        let (ours, _) = info(&mission, file);
        let topics = ours["topics"].as_array().unwrap();
        assert_eq!(told["topics"].as_object().unwrap().len(), topics.len());
        for topic in topics {
            assert_eq!(told["topics"][topic["topic"].as_str().unwrap()], topic["messages"], "{topic}");
        }
        assert_eq!(told["digest"], ours["digest"]);
        let decisions: Vec<u64> = told["decisions"].as_array().unwrap().iter().map(count).collect();
        assert!(decisions.iter().copied().eq(0..count(&ours["records"])), "{decisions:?}");
        assert_eq!(told["cells"]["seen"], told["cells"]["finite"]);
        assert_eq!(told["metadata"]["hopper"]["seed"], ours["seed"]);
    }
    let told = python::read(&python, "read.py", &mission.path("a.mcap"));
    assert_eq!(told["metadata"]["end"]["digest"], summary["digest"]);
    assert_eq!(told["cells"]["bytes"], 19 * count(&told["cells"]["seen"]));
    let told = python::read(&python, "read.py", &mission.path("whole.mcap"));
    assert!(told["metadata"]["recovered"]["fault"].as_str().is_some_and(|fault| !fault.is_empty()), "{told}");
}

/// P-BAG-END: A recording is finished properly however the monitor ends, except by a kill.
#[test]
fn a_recording_has_an_end_though_the_mission_has_none() {
    let mission = Mission::new("cut");
    let mut slow = mission.start_slow_sim("6");
    let _crew = ["perception", "planner"].map(|role| mission.start(role, &[]));
    mission.await_decisions(1);
    let mut monitor = mission.start("monitor", &["--record", "a.mcap", "--wait", "3s"]);
    harness::eventually("a record in the recording", || {
        let output = bag(&mission, &["info", "--format", "json"], "a.mcap");
        matches!(output.status.code(), Some(0 | 1)) && count(&json(&output)["records"]) >= 1
    });
    slow.kill();
    assert_eq!(monitor.code(), 4, "{}", monitor.log());
    let (told, code) = info(&mission, "a.mcap");
    assert_eq!(
        (code, &told["whole"], &told["status"]),
        (Some(0), &true.into(), &"underway".into()),
        "{told}"
    );
}

/// P-BAG-CODE: A mission whose recording is incomplete has exit code 1, after its summary, which
/// names all its files.
#[test]
fn a_recording_that_is_not_whole_is_no_success() {
    let mission = Mission::new("failing");
    let mut run = mission.hopper(&["run", "--instance", &mission.name, "--out", "out", "--format", "json"]);
    run.args(["--record", "a.mcap", "--seed", "7", "--pace", "10"]).env("HOPPER_CRASH", "monitor.joined");
    let output = run.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("--record a.mcap needs a complete recording"), "{}", stderr(&output));
    let summary = json(&output);
    assert_eq!(
        (&summary["outcome"], &summary["digest"]),
        (&"goal".into(), &lockstep(&["--seed", "7"])["digest"])
    );
    assert_eq!(summary["artifacts"]["recording"], "a.mcap");
    assert_eq!(summary["artifacts"]["recording-2"], "a-2.mcap", "{summary}");
}

/// P-BAG-STALL: A recorder that is stopped during a mission delays no hop.
#[test]
fn a_stopped_recorder_holds_up_no_hop() {
    let mission = Mission::new("stalled");
    let mut sim = mission.start("sim", &["--seed", "9", "--pace", "10"]);
    let monitor = mission.start("monitor", &["--record", "a.mcap"]);
    monitor.await_log("joined");
    // No hop before it has begun to record.
    let _peers = ["perception", "planner"].map(|role| mission.start(role, &[]));
    mission.await_decisions(3);
    monitor.signal(rustix::process::Signal::STOP);
    let stopped_at = mission.decisions();
    assert_eq!(sim.code(), 0, "{}", sim.log());
    let flown = sim.json();
    assert!(stopped_at + 3 < count(&flown["decisions"]), "stopped at {stopped_at}: {flown}");
    let recorded = count(&info(&mission, "a.mcap").0["decisions"]);
    assert!(
        recorded <= stopped_at,
        "{recorded} decisions by a recorder that stood still from {stopped_at} on"
    );
    assert_eq!(flown["digest"], lockstep(&["--seed", "9"])["digest"]);
}

/// P-BAG-OVERFLOW: If the recorder's queues overflow, the recording still has the record of every
/// decision, and the report says both.
#[test]
fn what_the_queue_lost_is_taken_from_the_past() {
    let mission = Mission::new("overflow");
    let patrol = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/patrol.toml"),
    );
    let short = patrol.unwrap().replace("hops_max = 1000000", "hops_max = 20000");
    std::fs::write(mission.path("short.toml"), short).unwrap();
    let mut sim = mission.start("sim", &["--scenario", "short.toml", "--seed", "5", "--pace", "max"]);
    let mut monitor = mission.start("monitor", &["--record", "a.mcap"]);
    monitor.await_log("joined");
    monitor.signal(rustix::process::Signal::STOP);
    let _peers = ["perception", "planner"].map(|role| mission.start(role, &[]));
    // More than the 64 states that its queue holds.
    mission.await_decisions(400);
    monitor.signal(rustix::process::Signal::CONT);
    assert_eq!((sim.code(), monitor.code()), (0, 0), "{}{}", sim.log(), monitor.log());
    let flown = sim.json();
    let (told, code) = info(&mission, "a.mcap");
    assert_eq!((code, &told["whole"], &told["complete"]), (Some(0), &true.into(), &true.into()), "{told}");
    assert_eq!((&told["records"], &told["decisions"]), (&flown["decisions"], &flown["decisions"]));
    assert_eq!((&told["digest"], &told["digest_at_end"]), (&flown["digest"], &flown["digest"]));
    let lost: u64 = told["gaps"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|gap| gap["topic"] == "hop/state")
        .map(|gap| 1 + count(&gap["through"]) - count(&gap["from"]))
        .sum();
    assert!(lost > 200, "{lost} states lost: {told}");
    let text = String::from_utf8(bag(&mission, &["info"], "a.mcap").stdout).unwrap();
    assert!(text.contains("missing     no decision") && text.contains("of hop/state"), "{text}");
    let rows = bag(&mission, &["export"], "a.mcap").stdout;
    assert_eq!(String::from_utf8(rows).unwrap().lines().count() as u64, 1 + count(&flown["decisions"]));
}

/// P-BAG-EMPTY: A recording without a mission in it is refused by every reader of missions, with
/// what is missing.
#[test]
fn a_recording_without_a_mission_is_refused() {
    let mission = Mission::new("bag-empty");
    let empty =
        recording::Recorder::new(&recording::Context::new(), contract::MonotonicNs(0)).unwrap().bytes();
    std::fs::write(mission.path("empty.mcap"), empty).unwrap();
    for words in [&["view", "empty.mcap", "--web", "127.0.0.1:0"][..], &["bag", "replay", "empty.mcap"]] {
        let output = mission.hopper(words).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        assert!(
            stderr(&output).contains("needs a brief on hop/brief, got 0 messages"),
            "{}",
            stderr(&output)
        );
    }
}

/// P-BAG-FILE: No recording is overwritten, and a file that is not a recording is refused.
#[test]
fn a_recording_is_never_written_over() {
    let mission = Mission::new("twice");
    std::fs::write(mission.path("a.mcap"), "precious").unwrap();
    for words in [&["run", "--record", "a.mcap"][..], &["monitor", "--record", "a.mcap"]] {
        let output = mission.hopper(words).args(["--instance", &mission.name]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("name another file"), "{}", stderr(&output));
    }
    assert_eq!(std::fs::read(mission.path("a.mcap")).unwrap(), b"precious");
    let lockstep = mission.hopper(&["run", "--lockstep", "--record", "b.mcap"]).output().unwrap();
    assert_eq!(lockstep.status.code(), Some(2));
    for words in [&["info"][..], &["replay"], &["export"]] {
        let output = bag(&mission, words, "a.mcap");
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(stderr(&output).contains("needs to begin with"), "{}", stderr(&output));
    }
}

/// P-BAG-AGAIN: A supervised monitor that was killed continues recording in another file.
#[test]
fn a_monitor_that_was_killed_records_on_in_another_file() {
    let mission = Mission::new("again");
    std::fs::write(mission.path("a.mcap"), "of the first life").unwrap();
    let mut monitor = hopper(&["monitor", "--lifeline", "--record", "a.mcap", "--instance", &mission.name]);
    // Standard input is closed, so the life ends as soon as it has begun.
    let output = monitor.current_dir(mission.path(".")).output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert_eq!(std::fs::read(mission.path("a.mcap")).unwrap(), b"of the first life");
    let (told, code) = info(&mission, "a-2.mcap");
    assert_eq!((code, &told["whole"]), (Some(0), &true.into()), "{told}");
}
