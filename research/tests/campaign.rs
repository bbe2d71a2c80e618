//! Campaigns of studies give the same rows whatever jobs, shards and kills, and the report of the study.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use ::campaign::checksum::{with_checksum, without_checksum};
use serde_json::Value;

/// A campaign file of `study` with `repetitions` worlds and `settings`.
fn file(study: &str, repetitions: u64, settings: &str) -> String {
    format!("name = \"tiny\"\nseed = 1\nrepetitions = {repetitions}\nstudy = \"{study}\"\n{settings}")
}

/// A folder with the campaign `text` in `c.toml`.
fn folder(text: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("c.toml"), text).unwrap();
    dir
}

fn research(dir: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-research"));
    command.args(words).current_dir(dir);
    command
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into()
}

/// Standard output of `hopper campaign WORDS` in `dir`, which must succeed.
fn campaign(dir: &Path, words: &[&str]) -> String {
    let output = research(dir, &[&["campaign"], words].concat()).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(dir: &Path, words: &[&str], says: &[&str]) {
    let output = research(dir, &[&["campaign"], words].concat()).output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {text}");
    for part in says {
        assert!(text.contains(part), "{words:?} does not say {part:?}: {text}");
    }
    assert!(!text.contains("panicked") && text.lines().count() <= 4, "one error: {text}");
}

/// Both forms of the rows.
fn rows(dir: &Path, folder: &str) -> [String; 2] {
    ["trials.jsonl", "trials.csv"].map(|name| fs::read_to_string(dir.join(folder).join(name)).unwrap())
}

/// P-STUDY-SHARDS: A campaign of each study has the same rows whatever the number of threads, and
/// its merged shards are the whole, byte for byte.
#[test]
fn rows_of_every_study_are_the_same_whatever_the_jobs_and_the_shards() {
    for (study, worlds) in [("p21", 4), ("p21-large", 2), ("p21-single", 12)] {
        let dir = folder(&file(study, worlds, ""));
        let dir = dir.path();
        campaign(dir, &["run", "c.toml", "--jobs", "1", "--out", "one"]);
        campaign(dir, &["run", "c.toml", "--jobs", "2", "--out", "two"]);
        let whole = rows(dir, "one");
        assert_eq!(whole[0].lines().count() as u64, worlds, "{study}");
        assert_eq!(rows(dir, "two"), whole, "{study}");
        for shard in ["2/2", "1/2"] {
            campaign(dir, &["run", "c.toml", "--shard", shard, "--out", &shard[..1]]);
        }
        campaign(dir, &["merge", "2", "1", "--out", "merged"]);
        assert_eq!(rows(dir, "merged"), whole, "{study}");
        assert_eq!(
            fs::read(dir.join("merged/campaign.json")).unwrap(),
            fs::read(dir.join("one/campaign.json")).unwrap()
        );
        let headings = whole[1].lines().next().unwrap().split(',').count();
        let mut csv = csv_records(&whole[1]);
        assert!(csv.all(|cells| cells == headings), "{study}: as many cells as headings");
        refused(dir, &["merge", "1", "--out", "m"], &["shard 2/2 is missing"]);
    }
}

/// Cells of each record; none of these rows quotes a comma.
fn csv_records(text: &str) -> impl Iterator<Item = usize> {
    text.lines().map(|line| line.split(',').count())
}

/// P-STUDY-RESUME: A campaign of a study that was killed resumes to the same rows, byte for byte.
#[test]
fn a_killed_campaign_of_a_study_resumes_to_the_same_rows() {
    let dir = folder(&file("p21-single", 400, ""));
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "whole"]);
    let mut child = research(dir, &["campaign", "run", "c.toml", "--jobs", "1", "--out", "cut"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let held = dir.join("cut/trials.jsonl");
    let began = Instant::now();
    while fs::metadata(&held).map_or(0, |file| file.len()) == 0 {
        assert!(began.elapsed() < Duration::from_secs(120), "no rows");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let lines = fs::read_to_string(&held).unwrap();
    assert!(lines.lines().count() < 400, "killed before its end");
    refused(dir, &["run", "c.toml", "--out", "cut"], &["--resume", "--out"]);
    // A kill may also fall within a line.
    fs::write(&held, lines + "{\"trial\":").unwrap();
    campaign(dir, &["run", "c.toml", "--out", "cut", "--resume"]);
    assert_eq!(rows(dir, "cut"), rows(dir, "whole"));
    assert_eq!(fs::read_to_string(dir.join("cut/times.csv")).unwrap().lines().count(), 401);
}

/// P-STUDY-RERUN: A trial of a study that is flown again equals its row. A row that no trial can
/// have, or that differs from its trial, is refused by name.
#[test]
fn a_trial_of_a_study_flown_again_is_its_row_and_another_row_is_told() {
    let dir = folder(&file("p21", 3, "[settings]\naccuracy = 0.8\n"));
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let [lines, _] = rows(dir, "a");
    let row = lines.lines().nth(1).unwrap();
    let again = campaign(dir, &["rerun", "a", "--trial", "1", "--out", "r", "--format", "json"]);
    assert_eq!(again.trim_end(), row);
    assert_eq!(fs::read_to_string(dir.join("r/row.json")).unwrap().trim_end(), row);
    assert!(fs::read_to_string(dir.join("r/fig-13.svg")).unwrap().starts_with("<svg"));
    refused(dir, &["rerun", "a", "--trial", "3", "--out", "r"], &["--trial", "0 to 2"]);

    let object = without_checksum(row).unwrap();
    let forged = object.replacen("\"stuck\":false", "\"stuck\":true", 1);
    let forged = forged.replacen("\"travel_sol\":", "\"travel_sol\":null,\"was\":", 1);
    let forge = |text: &str| {
        let line = with_checksum(text.strip_suffix('}').unwrap());
        fs::write(dir.join("a/trials.jsonl"), lines.replace(row, &line)).unwrap();
    };
    forge(&forged);
    refused(dir, &["report", "a"], &["line 2", "unknown field `was`"]);
    forge(&object.replacen("\"has_route\":true", "\"has_route\":false", 1));
    refused(dir, &["report", "a"], &["trial 1: travel_sol: need none without a way to the goal"]);
    forge(&object.replacen("\"travel_sol\":", "\"travel_sol\":9", 1));
    let output = research(dir, &["campaign", "rerun", "a", "--trial", "1", "--out", "s"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("trial 1: need its row"), "{}", stderr(&output));
}

/// P-STUDY-REPORT: The report of a study against its paper sets our result beside each claim, and
/// names the claims that do not hold, are open or cannot be tested.
#[test]
fn the_report_of_a_study_names_the_claims_that_do_not_reproduce() {
    let dir = folder(&file("p21-single", 100, ""));
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let text = campaign(dir, &["report", "a", "--against", "paper"]);
    let (reproducible, times) = text.split_once("## Times").expect("times stand apart");
    assert!(times.contains("| 100 |"), "{times}");
    insta::assert_snapshot!("report_of_a_study", reproducible);
    for words in ["does not hold: ", "cannot be had: "] {
        assert!(reproducible.contains(&format!("- {words}")), "{words}");
    }

    let plain = campaign(dir, &["report", "a"]);
    assert!(!plain.contains("claim") && plain.contains("| utility |"), "{plain}");
    let claims = campaign(dir, &["report", "a", "--against", "paper", "--format", "csv"]);
    assert_eq!(claims.lines().count(), 1 + 7);
    assert!(claims.starts_with("claim,paper,holds_if,ours,verdict\n"), "{claims}");
    let arms = campaign(dir, &["report", "a", "--format", "csv"]);
    assert_eq!(csv_records(&arms).collect::<Vec<_>>(), [20; 4]);
    let json: Value = serde_json::from_str(&campaign(dir, &["report", "a", "--format", "json"])).unwrap();
    assert!(json["claims"].is_null() && json["rows"].as_array().unwrap().len() == 3);
    campaign(dir, &["report", "a", "--against", "paper", "--format", "svg", "--out", "r"]);
    for name in ["report.md", "report.csv", "report.json", "fig-14.svg", "fig-15.svg"] {
        assert!(dir.join("r").join(name).is_file(), "{name}");
    }
    refused(dir, &["report", "a", "--readings"], &["--readings", "p21-single"]);
}

/// P-STUDY-SAME: The report of a study's campaign equals that of the command that flies the study
/// at once, figures included.
///
/// One computation, whether its outcomes are kept in memory or as rows.
#[test]
fn the_report_of_a_campaign_is_that_of_the_command_that_flies_it_at_once() {
    for (study, worlds, settings, command) in [
        (
            "p21",
            3,
            "[settings]\nrover = \"ett_exact\"\n",
            &["scouting", "--runs", "3", "--rover", "ett_exact"][..],
        ),
        ("p21-large", 2, "[settings]\nstages = 2\n", &["scouting", "large", "--runs", "2", "--stages", "2"]),
        ("p21-single", 20, "", &["scouting", "single", "--runs", "20"]),
    ] {
        let dir = folder(&file(study, worlds, settings));
        let dir = dir.path();
        campaign(dir, &["run", "c.toml", "--out", "a"]);
        let report = campaign(dir, &["report", "a", "--against", "paper", "--format", "json", "--out", "r"]);
        let at_once =
            research(dir, &[command, &["--format", "json", "--out", "o"]].concat()).output().unwrap();
        assert_eq!(report, String::from_utf8(at_once.stdout).unwrap(), "{study}");
        for entry in fs::read_dir(dir.join("o")).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|end| end == "svg") {
                let name = path.file_name().unwrap();
                assert!(fs::read(&path).unwrap() == fs::read(dir.join("r").join(name)).unwrap(), "{name:?}");
            }
        }
    }
}

/// P-STUDY-COVERAGE: Shards of the coverage study, none of which has all cases of a world, merge to
/// the report of `hopper coverage`.
#[test]
fn shards_of_coverage_merged_give_the_report_of_the_study() {
    let dir = folder(&file("p19", 100, ""));
    let dir = dir.path();
    for shard in ["1/3", "2/3", "3/3"] {
        campaign(dir, &["run", "c.toml", "--shard", shard, "--out", &shard[..1]]);
    }
    refused(
        dir,
        &["report", "1"],
        &["need at least 100 worlds with all of their 86 cases", "merge its shards"],
    );
    campaign(dir, &["merge", "1", "2", "3", "--out", "a"]);
    let report = campaign(dir, &["report", "a", "--against", "paper", "--format", "json"]);
    let at_once = research(dir, &["coverage", "--runs", "100", "--format", "json"]).output().unwrap();
    assert!(report == String::from_utf8(at_once.stdout).unwrap(), "the report of the study");
    let again = campaign(dir, &["rerun", "a", "--trial", "8", "--out", "r", "--format", "json"]);
    assert_eq!(again.trim_end(), rows(dir, "a")[0].lines().nth(8).unwrap());
    assert!(fs::read_to_string(dir.join("r/visits.svg")).unwrap().contains("spiral overlap 4 on 20x20"));
}

/// P-STUDY-FILE: Every impossible campaign of a study is refused with one error that names the
/// field, before anything is written.
#[test]
fn campaigns_of_studies_that_cannot_be_are_refused_by_name() {
    let good = file("p21-large", 2, "[settings]\nstages = 2\ngood = 0.5\n");
    let dir = folder(&good);
    let dir = dir.path();
    for (from, to, says) in [
        ("\"p21-large\"", "\"p22\"", "study: need one of p21, p21-large, p21-single, p19, got \"p22\""),
        ("\"p21-large\"", "7", "study: need one of"),
        ("seed = 1", "sead = 1", "sead"),
        ("\"tiny\"", "\"../tiny\"", "name: need"),
        ("repetitions = 2", "repetitions = 1", "repetitions: need at least 2"),
        ("repetitions = 2", "repetitions = 2000000000", "at most 1000000000 trials in all"),
        ("stages = 2", "stages = 21", "stages: need 1 to 20, got 21"),
        ("good = 0.5", "good = nan", "good: need a probability"),
        ("good = 0.5", "god = 0.5", "god"),
        ("good = 0.5", "rover = \"teleport\"", "teleport"),
        ("study =", "scenarios = [\"hard\"]\nstudy =", "scenarios"),
    ] {
        let text = good.replace(from, to);
        assert_ne!(text, good, "{from}");
        fs::write(dir.join("bad.toml"), text).unwrap();
        let output = research(dir, &["campaign", "run", "bad.toml", "--out", "bad"]).output().unwrap();
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{to}: {error}");
        assert!(error.contains(says) && !error.contains("panicked"), "{to} does not say {says:?}: {error}");
    }
    assert!(!dir.join("bad").exists(), "nothing is written for a campaign that cannot be flown");
    fs::write(dir.join("few.toml"), file("p19", 99, "")).unwrap();
    refused(dir, &["run", "few.toml"], &["few.toml: repetitions: need at least 100"]);

    campaign(dir, &["run", "c.toml", "--shard", "1/2", "--out", "a"]);
    refused(dir, &["report", "a"], &["need at least 2 worlds", "got 1", "shard 1/2"]);
    let plan = fs::read_to_string(dir.join("a/campaign.json")).unwrap();
    fs::write(dir.join("a/campaign.json"), plan.replace("\"stages\": 2", "\"stages\": 3")).unwrap();
    refused(dir, &["report", "a"], &["campaign.json", "need checksum"]);
    let other = good.replace("stages = 2", "stages = 3");
    fs::write(dir.join("a/campaign.json"), plan).unwrap();
    fs::write(dir.join("other.toml"), other).unwrap();
    refused(
        dir,
        &["run", "other.toml", "--shard", "1/2", "--out", "a", "--resume"],
        &["another campaign", "plan"],
    );
}
