//! What a new user types on the first day works, or is answered with what does.

use crate::harness::{self, Mission, Process, hopper, json, lockstep, stderr};
use rustix::process::Signal;

/// Standard error of `hopper WORDS`, which must fail with `code`.
fn refused(words: &[&str], code: i32) -> String {
    let output = hopper(words).output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{words:?}: {text}");
    text
}

/// Standard output of `hopper WORDS`, which must succeed.
fn answer(words: &[&str]) -> String {
    let output = hopper(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// P-TYPO: A mistyped command is answered with the one it resembles, a bad number in plain words.
#[test]
fn a_mistyped_command_is_answered_with_the_one_meant() {
    for (words, meant) in [
        (&["rnu"][..], "'run'"),
        (&["smi"], "'sim'"),
        (&["doctr"], "'doctor'"),
        (&["campaign", "rnu"], "'run'"),
        (&["topic", "ecoh"], "'echo'"),
    ] {
        let text = refused(words, 2);
        assert!(text.contains(&format!("a similar subcommand exists: {meant}")), "{words:?}: {text}");
    }
    assert!(!refused(&["xyzzy"], 2).contains("similar"), "nothing resembles it");
    for (words, plain) in [
        (&["run", "--seed", "-1"][..], "'--seed <SEED>': need a whole number without sign or fraction"),
        (&["sim", "--seed", "1.5"], "need a whole number without sign or fraction"),
        (&["run", "--seed", "99999999999999999999"], "the number is too large"),
        (&["topic", "echo", "state", "--count", "x"], "need a whole number"),
        (&["sim", "--wait", "soon"], "need a duration such as 30s"),
    ] {
        let text = refused(words, 2);
        assert!(text.contains(plain) && !text.contains("digit"), "{words:?}: {text}");
    }
}

/// P-LISTS: Built-in scenarios and campaigns are listed with a line each, and flown by name.
#[test]
fn built_in_scenarios_and_campaigns_are_listed_and_flown_by_name() {
    let scenarios = answer(&["scenario", "list"]);
    assert_eq!(scenarios.lines().count(), 1 + scenario::BUILT_IN.len(), "{scenarios}");
    let is_sandy = |line: &str| line.starts_with("sandy ") && line.contains("  The paper's sandy ground");
    assert!(scenarios.lines().any(is_sandy), "{scenarios}");
    let listed: serde_json::Value =
        serde_json::from_str(&answer(&["scenario", "list", "--format", "json"])).unwrap();
    assert_eq!(listed.as_array().unwrap().len(), scenario::BUILT_IN.len());
    assert!(answer(&["run", "--help"]).contains("hopper scenario list"));

    let campaigns = answer(&["campaign", "list"]);
    let dir = tempfile::tempdir().unwrap();
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/campaigns")).unwrap();
    let mut count = 0;
    for file in files {
        let path = file.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert!(campaigns.lines().any(|line| line.starts_with(&format!("{name} "))), "{name}: {campaigns}");
        count += 1;
    }
    assert_eq!(campaigns.lines().count(), 1 + count, "{campaigns}");
    // One trial of so many shards is enough to know; it is the very trial of the file.
    let trial = |campaign: &str, out: &str| {
        let words = ["campaign", "run", campaign, "--shard", "3000/3000", "--out", out];
        let output = hopper(&words).current_dir(dir.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        std::fs::read(dir.path().join(out).join("trials.jsonl")).unwrap()
    };
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/campaigns/p23-tables.toml");
    assert_eq!(trial("p23-tables", "by-name"), trial(file, "by-file"));
    let unknown = refused(&["campaign", "run", "p23-table"], 2);
    assert!(
        unknown.contains("p23-table: need a campaign, found none; did you mean p23-tables?"),
        "{unknown}"
    );
}

/// P-PAPER-SPEED: Only campaigns of the paper's own cells are timed beside the paper's machine.
#[test]
fn a_campaign_of_ones_own_is_not_timed_beside_the_papers_machine() {
    const MINE: &str =
        "name = \"mine\"\nseed = 1\nrepetitions = 2\nscenarios = [\"hard\"]\nplanners = [\"mdp\"]\n";
    let dir = tempfile::tempdir().unwrap();
    let fly = |file: &str, text: &str| {
        std::fs::write(dir.path().join(file), text).unwrap();
        let fly = ["campaign", "run", file, "--out", file.trim_end_matches(".toml")];
        let output = hopper(&fly).current_dir(dir.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report = ["campaign", "report", file.trim_end_matches(".toml")];
        let report = hopper(&report).current_dir(dir.path()).output().unwrap();
        let told = String::from_utf8(output.stdout).unwrap().contains("paper's machine");
        (told, String::from_utf8(report.stdout).unwrap().contains("| 44300 |"))
    };
    assert_eq!(fly("papers.toml", MINE), (true, true));
    assert_eq!(fly("profile.toml", &format!("{MINE}profiles = [\"hopper\"]\n")), (false, false));
    let weights = "weights = [{ safety = 0.3, information = 0.7 }]\n";
    assert_eq!(fly("weights.toml", &format!("{MINE}{weights}")), (false, false));
    let both = MINE.replace("[\"hard\"]", "[\"hard\", \"hills\"]");
    assert_eq!(
        fly("ground.toml", &both),
        (false, true),
        "the paper's own cell of it stays beside the paper's"
    );
}

/// P-FIELDS-NAMED: An error in a scenario names a field that exists, and the file.
#[test]
fn an_impossible_scatter_is_named_by_its_section_and_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("mine.toml");
    let text = include_str!("../scenarios/hard.toml");
    for (from, to, says) in [
        (
            "intended = 0.9,",
            "intended = 0.99,",
            "robot.hard: need intended + stuck + 2 x sideways = 1, got 0.99 + 0 + 2 x 0.05 = 1.09",
        ),
        ("intended = 0.7,", "intended = 0.6,", "robot.sand: need intended + stuck + 2 x sideways = 1"),
        ("offset_m = 1.0", "radius_min_m = 0.1", "robot.sensor.radius_min_m: need at least one hop"),
    ] {
        assert!(text.contains(from));
        std::fs::write(&path, text.replace(from, to)).unwrap();
        let file = path.to_str().unwrap();
        for words in [&["scenario", "check", file][..], &["run", "--lockstep", "--scenario", file]] {
            let refused = refused(words, 2);
            assert!(refused.contains(&format!("mine.toml: {says}")), "{refused}");
        }
    }
}

/// P-STEP-LIMIT: The summary of a mission that ran out of steps says so, with the limit.
#[test]
fn running_out_of_steps_is_called_so() {
    let mission = Mission::new("out-of-steps");
    let text = include_str!("../scenarios/hard.toml").replace("steps_max = 150", "steps_max = 9");
    std::fs::write(mission.path("short.toml"), text).unwrap();
    let output =
        mission.hopper(&["run", "--lockstep", "--scenario", "short.toml", "--out", "out"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(
        summary.contains("Out of steps at (") && summary.contains("5 hops, 10 steps, limit 9."),
        "{summary}"
    );
    assert!(!summary.contains("Deadlock") && !summary.contains("10 of 9"), "{summary}");
}

/// P-JOURNAL-OF-RUN: Every command that reads a journal also takes the output directory of its run.
#[test]
fn the_folder_of_a_run_stands_for_its_journal() {
    let mission = Mission::new("folder-of-run");
    let flown = mission.hopper(&["run", "--lockstep", "--out", "out", "--format", "json"]).output().unwrap();
    let digest = &json(&flown)["digest"];
    for folder in ["out", "out/journal"] {
        let verified = mission.hopper(&["journal", "verify", folder, "--format", "json"]).output().unwrap();
        assert_eq!(&json(&verified)["digest"], digest, "{folder}");
        let shown = mission.hopper(&["journal", "show", folder]).output().unwrap();
        assert_eq!(shown.status.code(), Some(0), "{}", stderr(&shown));
        let again = ["run", "--lockstep", "--planners-from", folder, "--format", "json"];
        assert_eq!(&json(&mission.hopper(&again).output().unwrap())["digest"], digest, "{folder}");
    }
    let empty = mission.hopper(&["journal", "verify", "."]).output().unwrap();
    assert_eq!(empty.status.code(), Some(2), "{}", stderr(&empty));
}

/// P-TWO-RUNS: A second run in an instance is refused before it creates a directory, with a free
/// name in the error. An interrupted run says how to resume; `--control` works without a page.
#[test]
fn a_second_run_is_told_of_instances_and_an_interrupted_one_how_to_resume() {
    let mission = Mission::new("two-runs");
    let words = ["run", "--instance", &mission.name, "--pace", "0.5", "--control", "--out", "first"];
    let mut first = Process::spawn("run", mission.hopper(&words), &mission.path(""));
    first.await_log(&format!("hopper monitor --tui --control --instance {}", mission.name));
    harness::eventually("a first decision", || {
        let verified = mission.hopper(&["journal", "verify", "first", "--format", "json"]).output().unwrap();
        let verified = serde_json::from_slice::<serde_json::Value>(&verified.stdout).unwrap_or_default();
        verified["decisions"].as_u64().is_some_and(|decisions| decisions > 0)
    });

    let second = mission.hopper(&["run", "--instance", &mission.name]).output().unwrap();
    assert_eq!(second.status.code(), Some(4), "{}", stderr(&second));
    let hint = format!("--instance {}-2", mission.name);
    assert!(stderr(&second).contains(&hint), "{}", stderr(&second));
    assert!(!mission.path("out").exists(), "it left a folder");

    first.signal(Signal::INT);
    assert_eq!(first.code(), 130, "{}", first.log());
    first.await_log("the same command with --out first resumes the mission");

    let mut sim = mission.start("sim", &[]);
    sim.await_log("joined instance");
    sim.signal(Signal::INT);
    assert_eq!(sim.code(), 130, "{}", sim.log());
    sim.await_log("the same command with --journal");
}

/// P-DOCTOR-NEXT. Advice about an instance names that instance, in every command.
#[test]
fn the_doctors_advice_names_the_instance() {
    let name = format!("advised-{}", std::process::id());
    let told = answer(&["doctor", "--instance", &name]);
    for command in ["hopper sim", "hopper run"] {
        assert!(told.contains(&format!("`{command} --instance {name}`")), "{told}");
    }
}

/// P-REFUSED-TRACELESS: A refused mission leaves no new directory, and no file in an existing one.
/// A path may begin with a hyphen, an instance's name may not.
#[test]
fn a_refused_mission_adds_nothing_to_a_folder() {
    let mission = Mission::new("adds-nothing");
    let folder = mission.path("mine");
    std::fs::create_dir(&folder).unwrap();
    for file in [None, Some("notes.txt"), Some("scenario.toml")] {
        let mine: Vec<_> = file.into_iter().map(|file| folder.join(file)).collect();
        mine.iter().for_each(|path| std::fs::write(path, include_str!("../scenarios/hard.toml")).unwrap());
        let words = ["run", "--instance", &mission.name, "--out", "mine", "--planner-command", "false"];
        let output = mission.hopper(&words).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        let left: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|file| file.unwrap().path()).collect();
        assert_eq!(left, mine, "{file:?}");
        for path in &mine {
            assert_eq!(std::fs::read_to_string(path).unwrap(), include_str!("../scenarios/hard.toml"));
            let is_a_scenario = file == Some("scenario.toml");
            assert_eq!(
                stderr(&output).contains("with a scenario.toml of yours"),
                is_a_scenario,
                "{}",
                stderr(&output)
            );
        }
        mine.iter().for_each(|path| std::fs::remove_file(path).unwrap());
    }
}

/// P-REFUSED-TRACELESS. A refused mission leaves no directory, and paths may begin with a hyphen.
#[test]
fn a_refused_mission_leaves_no_folder_and_a_path_may_look_like_a_flag() {
    let mission = Mission::new("traceless");
    let flies = |words: &[&str]| mission.hopper(&["run", "--seed", "3"]).args(words).output().unwrap();
    let instance = format!("--instance={}", mission.name);
    let missing = mission.path("missing").to_string_lossy().into_owned();
    for (words, need) in [
        (&["--instance=-x"][..], "instance"),
        (&["--instance=-x", "--out", "deep/er"], "instance"),
        (&[&instance, "--planner-command", "true", "--patience", "5s"], "--planner-command"),
        (&[&instance, "--web", "192.0.2.1:1"], "--web"),
        (&[&instance, "--planner-command", &missing], "--planner-command"),
    ] {
        let output = flies(words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(need), "{words:?}: {}", stderr(&output));
        let left: Vec<_> =
            std::fs::read_dir(mission.path("")).unwrap().flatten().map(|file| file.path()).collect();
        assert!(left.is_empty(), "{words:?} left {left:?}");
    }
    let output = flies(&[&instance, "--out=-out", "--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(json(&output)["digest"], lockstep(&["--seed", "3"])["digest"]);
}
