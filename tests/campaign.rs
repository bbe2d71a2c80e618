//! Campaigns give the same rows whatever jobs, shards and kills, and say what they come to.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::harness::{self, Process, eventually, hopper, json, stderr};
use ::campaign::checksum::{with_checksum, without_checksum};
use serde_json::Value;

const TINY: &str = r#"
name = "tiny"
seed = 11
repetitions = 5
scenarios = ["hard", "sandy"]
planners = ["mdp", "greedy"]
weights = [{ safety = 0.5, information = 0.5 }]
"#;

/// A folder with the campaign `text` in `c.toml`.
fn folder(text: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("c.toml"), text).unwrap();
    dir
}

fn done(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", stderr(&output));
    output
}

/// `hopper campaign WORDS` in `dir`, which must succeed.
fn campaign(dir: &Path, words: &[&str]) -> Output {
    let mut command = hopper(&["campaign"]);
    command.args(words).current_dir(dir);
    done(command)
}

fn refused(dir: &Path, words: &[&str], says: &[&str]) {
    let output = hopper(&["campaign"]).args(words).current_dir(dir).output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {text}");
    for part in says {
        assert!(text.contains(part), "{words:?} does not say {part:?}: {text}");
    }
    assert!(!text.contains("panicked") && text.lines().count() <= 12 && text.len() < 3000, "{text}");
}

/// A row in which `from` has become `to`, with a new checksum.
fn forged(line: &str, from: &str, to: &str) -> String {
    with_checksum(without_checksum(line).unwrap().replace(from, to).strip_suffix('}').unwrap())
}

/// Both forms of the rows, byte for byte.
fn rows(dir: PathBuf) -> (String, String) {
    let read = |file| fs::read_to_string(dir.join(file)).unwrap();
    (read("trials.jsonl"), read("trials.csv"))
}

/// P-ROWS: A campaign has the same rows whatever the number of threads.
#[test]
fn rows_are_equal_whatever_the_jobs() {
    let dir = folder(TINY);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--jobs", "1", "--out", "one"]);
    let run = json(&campaign(dir, &["run", "c.toml", "--jobs", "2", "--out", "two", "--format", "json"]));
    assert_eq!((&run["flown"], &run["jobs"]), (&20.into(), &2.into()));
    assert!(run["episodes_per_s"].as_f64().unwrap() > 0.0 && run["paper_ratio"].as_f64().unwrap() > 1.0);
    assert_eq!(rows(dir.join("one")), rows(dir.join("two")));
    let (lines, table) = rows(dir.join("one"));
    let seeds: std::collections::BTreeSet<_> = lines
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["seed"].as_u64().unwrap())
        .collect();
    assert_eq!((lines.lines().count(), table.lines().count(), seeds.len()), (20, 21, 20));
}

/// P-SHARDS: Merged shards equal the whole, byte for byte; missing, unfinished and foreign shards
/// are refused.
#[test]
fn shards_merged_are_the_whole() {
    let dir = folder(TINY);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "whole"]);
    for shard in ["3/3", "1/3", "2/3"] {
        campaign(dir, &["run", "c.toml", "--shard", shard, "--out", &shard[..1]]);
    }
    campaign(dir, &["merge", "2", "3", "1", "--out", "merged"]);
    assert_eq!(rows(dir.join("merged")), rows(dir.join("whole")));
    refused(dir, &["merge", "1", "2", "--out", "m"], &["shard 3/3 is missing"]);
    refused(dir, &["merge", "1", "2", "3", "3", "--out", "m"], &["shard 3/3 is given twice"]);
    refused(dir, &["merge", "1", "2", "whole", "--out", "m"], &["shards of one campaign"]);
    let lines = fs::read_to_string(dir.join("2/trials.jsonl")).unwrap();
    let cut: String = lines.lines().take(3).flat_map(|line| [line, "\n"]).collect();
    fs::write(dir.join("2/trials.jsonl"), cut).unwrap();
    refused(dir, &["merge", "1", "2", "3", "--out", "m"], &["shard 2/3 is not finished", "--resume"]);
    campaign(dir, &["run", "c.toml", "--shard", "2/3", "--out", "2", "--resume"]);
    campaign(dir, &["merge", "1", "2", "3", "--out", "again"]);
    assert_eq!(rows(dir.join("again")), rows(dir.join("whole")));
}

/// P-RESUME: A killed campaign resumes to the same rows, wherever the kill happened.
#[test]
fn a_killed_campaign_resumes_to_the_same_rows() {
    let text = TINY.replace("repetitions = 5", "repetitions = 250").replace("\"mdp\", ", "");
    let dir = folder(&text);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "whole"]);

    let mut child = hopper(&["campaign", "run", "c.toml", "--jobs", "1", "--out", "cut"])
        .current_dir(dir)
        .spawn()
        .unwrap();
    let held = dir.join("cut/trials.jsonl");
    eventually("first rows", || fs::metadata(&held).is_ok_and(|file| file.len() > 0));
    child.kill().unwrap();
    child.wait().unwrap();
    refused(dir, &["run", "c.toml", "--out", "cut"], &["--resume", "--out"]);

    // A kill may also fall between the files, and within a line.
    let mut lines = fs::read_to_string(&held).unwrap();
    lines += "{\"trial\":";
    fs::write(&held, lines).unwrap();
    let table = fs::read_to_string(dir.join("cut/trials.csv")).unwrap();
    fs::write(dir.join("cut/trials.csv"), &table[..table.len().saturating_sub(300)]).unwrap();

    campaign(dir, &["run", "c.toml", "--out", "cut", "--resume"]);
    assert_eq!(rows(dir.join("cut")), rows(dir.join("whole")));
    assert_eq!(fs::read_to_string(dir.join("cut/times.csv")).unwrap().lines().count(), 501);
    let again = json(&campaign(dir, &["run", "c.toml", "--out", "cut", "--resume", "--format", "json"]));
    assert_eq!((&again["flown"], &again["trials"]), (&0.into(), &500.into()));
    assert_eq!(rows(dir.join("cut")), rows(dir.join("whole")));
}

/// P-GRID: A trial's seed is the same wherever its cell stands in the grid.
#[test]
fn a_trials_seed_is_its_own_wherever_its_cell_stands() {
    let dir = folder(&TINY.replace("\"hard\", \"sandy\"", "\"sandy\"").replace("\"mdp\", ", ""));
    let dir = dir.path();
    fs::write(dir.join("d.toml"), TINY.replace("\"mdp\", ", "")).unwrap();
    campaign(dir, &["run", "c.toml", "--out", "small"]);
    campaign(dir, &["run", "d.toml", "--out", "large"]);
    let digests = |name: &str| -> Vec<Value> {
        let (lines, _) = rows(dir.join(name));
        let rows = lines.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        rows.filter(|row| row["scenario"] == "sandy").map(|row| row["digest"].clone()).collect()
    };
    assert_eq!(digests("small"), digests("large"));
    refused(dir, &["run", "d.toml", "--out", "small", "--resume"], &["another campaign", "plan"]);
}

/// P-TRIAL: A trial is the mission that `hopper run` would fly.
///
/// The weights of a trial override the scenario's, and are part of what it is.
#[test]
fn a_trial_is_the_mission_that_hopper_run_would_fly() {
    let dir = folder(
        &TINY.replace("\"hard\", \"sandy\"", "\"sandy\"").replace("repetitions = 5", "repetitions = 1"),
    );
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let (lines, _) = rows(dir.join("a"));
    for line in lines.lines() {
        let row: Value = serde_json::from_str(line).unwrap();
        let words = [
            "--scenario",
            "sandy",
            "--seed",
            &row["seed"].to_string(),
            "--planner",
            row["planner"].as_str().unwrap(),
        ];
        let summary = harness::lockstep(&words);
        for field in ["digest", "steps", "hops", "outcome", "coverage"] {
            assert_eq!(summary[field], row[field], "{field}");
        }
    }
    fs::write(
        dir.join("w.toml"),
        TINY.replace("0.5 }", "0.25 }").replace("repetitions = 5", "repetitions = 1"),
    )
    .unwrap();
    campaign(dir, &["run", "w.toml", "--out", "w"]);
    assert!(rows(dir.join("w")).0.contains("\"information\":0.25"));
}

/// P-RERUN: A trial that is flown again has the digest of its row, with picture and journal.
#[test]
fn a_trial_flown_again_has_the_digest_of_its_row() {
    let dir = folder(TINY);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let (lines, _) = rows(dir.join("a"));
    let row: Value = serde_json::from_str(lines.lines().nth(13).unwrap()).unwrap();
    let summary = json(&campaign(dir, &["rerun", "a", "--trial", "13", "--out", "r", "--format", "json"]));
    assert_eq!(summary["digest"], row["digest"]);
    assert_eq!(harness::verify(&dir.join("r/journal"))["digest"], row["digest"]);
    assert!(fs::read_to_string(dir.join("r/mission.svg")).unwrap().contains("<svg"));
    refused(dir, &["rerun", "a", "--trial", "20", "--out", "s"], &["--trial", "0 to 19"]);

    let digest = row["digest"].as_str().unwrap();
    let forged = lines.lines().map(|line| forged(line, digest, &"0".repeat(64)) + "\n");
    fs::write(dir.join("a/trials.jsonl"), forged.collect::<String>()).unwrap();
    let output =
        hopper(&["campaign", "rerun", "a", "--trial", "13", "--out", "t"]).current_dir(dir).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains(digest), "{}", stderr(&output));
}

/// P-NO-LINK. A campaign refuses a link where it writes, and leaves the link's target as it is.
#[test]
fn links_in_place_of_rows_are_refused() {
    let dir = folder(TINY);
    let precious = dir.path().join("precious");
    fs::write(&precious, "theirs").unwrap();
    for name in ["campaign.json.new", "trials.jsonl", "trials.csv", "times.csv"] {
        let out = dir.path().join(name);
        fs::create_dir(&out).unwrap();
        std::os::unix::fs::symlink(&precious, out.join(name)).unwrap();
        refused(dir.path(), &["run", "c.toml", "--out", name], &["needs to be a file, got a symbolic link"]);
    }
    assert_eq!(fs::read_to_string(&precious).unwrap(), "theirs");
}

/// P-CAMPAIGN-INTERRUPT: An interrupted campaign keeps its rows, prints how many, and exits with
/// code 130.
#[test]
fn an_interrupted_campaign_says_what_it_keeps() {
    // More than anybody would wait for.
    let dir = folder(&TINY.replace("repetitions = 5", "repetitions = 1000000"));
    let held = dir.path().join("cut/trials.jsonl");
    let mut rows = 0;
    for words in [&[][..], &["--resume"]] {
        let mut command = hopper(&["campaign", "run", "c.toml", "--jobs", "2", "--out", "cut"]);
        command.args(words).current_dir(dir.path());
        let mut run = Process::spawn("campaign", command, dir.path());
        run.await_log(&format!("{rows} of 4000000 trials are in the folder"));
        let before = fs::metadata(&held).map_or(0, |file| file.len());
        eventually("more rows", || fs::metadata(&held).is_ok_and(|file| file.len() > before));
        run.signal(rustix::process::Signal::INT);
        assert_eq!(run.code(), 130, "{}", run.log());
        let lines = fs::read_to_string(&held).unwrap();
        assert!(lines.ends_with('\n') && lines.lines().count() > rows, "{rows} rows before");
        rows = lines.lines().count();
        let said = format!("interrupted: {rows} of 4000000 trials are kept in cut");
        assert!(run.log().contains(&said) && run.log().contains("--resume"), "{said}: {}", run.log());
        assert!(run.out().is_empty(), "{}", run.out());
    }
}

/// P-CAMPAIGN-FILE: Bad campaigns are refused before anything is written, and the error names the
/// field.
#[test]
fn bad_campaigns_are_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    refused(dir, &["run", "none.toml"], &["none.toml", "need a campaign file"]);
    let many = format!("scenarios = {:?}", (0..5000).map(|number| number.to_string()).collect::<Vec<_>>());
    for (from, to, says) in [
        ("seed = 11", "sead = 11", "sead"),
        ("seed = 11", "seed = -1", "seed"),
        ("seed = 11", "seed = 11\nseed = 12", "duplicate key"),
        ("name = \"tiny\"", "", "name"),
        ("\"tiny\"", "\"../tiny\"", "name: need"),
        ("repetitions = 5", "repetitions = 0", "repetitions: need"),
        ("repetitions = 5", "repetitions = 9000000000000000000", "repetitions: need"),
        ("\"mdp\"", "\"teleport\"", "teleport"),
        ("\"mdp\", \"greedy\"", "", "planners: need at least one"),
        ("\"greedy\"", "\"mdp\"", "twice"),
        ("\"hard\"", "\"no-such\"", "no-such"),
        ("\"hard\"", "7", "string"),
        ("repetitions = 5", "repetitions = 300000000", "at most 1000000000 trials in all"),
        ("scenarios = [\"hard\", \"sandy\"]", &many, "at most 4096 cells"),
        ("safety = 0.5", "safety = nan", "weights"),
        ("safety = 0.5", "saftey = 0.5", "saftey"),
        ("repetitions = 5", "repetitions = 5\nprofiles = [\"teleport\"]", "paper-2023"),
    ] {
        let text = TINY.replace(from, to);
        assert_ne!(text, TINY, "{from}");
        fs::write(dir.join("bad.toml"), text).unwrap();
        refused(dir, &["run", "bad.toml", "--out", "bad"], &["bad.toml", says]);
    }
    // 120 worlds of 674,041 cells.
    let weights: Vec<String> =
        (0..60).map(|part| format!("{{ safety = 0.{part:03}, information = 0 }}")).collect();
    let vast = TINY.replace("[\"hard\", \"sandy\"]", "[\"vast\"]");
    let vast = vast.replace("{ safety = 0.5, information = 0.5 }", &weights.join(", "));
    fs::write(dir.join("bad.toml"), vast).unwrap();
    refused(
        dir,
        &["run", "bad.toml", "--out", "bad"],
        &["bad.toml: scenarios: need at most 67108864 cells of ground"],
    );
    let large = fs::File::create(dir.join("bad.toml")).unwrap();
    large.set_len(1 << 40).unwrap();
    refused(dir, &["run", "bad.toml", "--out", "bad"], &["bad.toml: need at most 1048576 bytes, got more"]);
    fs::write(dir.join("bad.toml"), format!("name = {}", "[".repeat(500_000))).unwrap();
    refused(dir, &["run", "bad.toml", "--out", "bad"], &["bad.toml", "max recursion depth"]);
    assert!(!dir.join("bad").exists(), "nothing is written for a campaign that cannot be flown");
    fs::write(dir.join("bad.toml"), [0xff, 0xfe, 0]).unwrap();
    refused(dir, &["run", "bad.toml"], &["bad.toml"]);
    fs::write(dir.join("good.toml"), TINY).unwrap();
    refused(dir, &["run", "good.toml", "--shard", "4/3"], &["--shard", "1 <= I <= N"]);
    refused(dir, &["run", "good.toml", "--jobs", "0"], &["--jobs"]);
    refused(dir, &["report", "nowhere"], &["nowhere"]);
    refused(dir, &["merge", "nowhere"], &["nowhere"]);
}

/// P-DAMAGED-ROWS: Damaged rows are refused, and the error names the line.
#[test]
fn damaged_rows_are_refused_by_line() {
    let dir = folder(TINY);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let (lines, _) = rows(dir.join("a"));
    let all: Vec<&str> = lines.lines().collect();
    let write = |rows: Vec<&str>| fs::write(dir.join("a/trials.jsonl"), rows.join("\n") + "\n").unwrap();
    write([&all[..3], &all[4..]].concat());
    refused(dir, &["report", "a"], &["line 4: need trial 3, got 4"]);
    let refuses = |line: &str, says: &str| {
        write([&all[..3], &[line], &all[4..]].concat());
        refused(dir, &["report", "a"], &["trials.jsonl", says]);
    };
    refuses("{}", "line 4: need an object that closes with its checksum");
    refuses(&all[3].replace("\"hops\":", "\"hops\":1"), "line 4: need checksum");
    refuses(&with_checksum("{\"trial\":3"), "line 4: missing field");
    refuses(&" ".repeat(20_000), "line 4: need at most 16384 bytes, got more");
    refuses(&forged(all[3], "\"config\":\"", "\"config\":\"0"), "trial 3: need configuration");
    refuses(&forged(all[3], "\"seed\":", "\"seed\":1"), "trial 3: need {");
    refuses(&forged(all[3], "\"coverage\":", "\"coverage\":7"), "line 4: coverage: need 0 to 1, got 7");
}

/// P-DAMAGED-PLAN: A plan that is damaged, edited or endless is refused, and the table of rows is
/// rebuilt from the rows.
#[test]
fn a_damaged_or_edited_plan_is_refused() {
    let dir = folder(TINY);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let plan = fs::read_to_string(dir.join("a/campaign.json")).unwrap();
    let refuses = |text: &str, says: &str| {
        fs::write(dir.join("a/campaign.json"), text).unwrap();
        for words in [&["report", "a"][..], &["run", "c.toml", "--out", "a", "--resume"]] {
            refused(dir, words, &["campaign.json", says]);
        }
    };
    refuses("", "the plan: need an object that closes with its checksum");
    refuses(&plan.replace("\"seed\": 11", "\"seed\": 13"), "the plan: need checksum");
    refuses(&(forged(plan.trim_end(), "\"seed\": 11", "\"seed\": 13") + "\n"), "need a plan of hash");
    refuses(&forged(plan.trim_end(), "\"count\": 1", "\"count\": 0"), "shard: need a shard is I/N");
    let large = fs::File::create(dir.join("a/campaign.json")).unwrap();
    large.set_len(1 << 40).unwrap();
    refused(dir, &["report", "a"], &["campaign.json", "need at most 67108864 bytes, got more"]);
    fs::write(dir.join("a/campaign.json"), plan).unwrap();
    // The table is made anew from the rows, which alone are believed.
    let table = dir.join("a/trials.csv");
    let good = fs::read(&table).unwrap();
    fs::write(&table, b"whatever\n").unwrap();
    campaign(dir, &["run", "c.toml", "--out", "a", "--resume"]);
    assert_eq!(fs::read(&table).unwrap(), good);
}

/// P-REPORT: The report of a small campaign matches its stored snapshot.
#[test]
fn the_report_of_a_tiny_campaign_is_as_ever() {
    let dir = folder(TINY);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let output = campaign(dir, &["report", "a", "--against", "paper"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let (reproducible, times) = text.split_once("## Times").expect("times stand apart");
    assert_eq!(times.matches("in paper-2023 |").count(), 4);
    // Version and plan's hash are new with every change of a source.
    let between = |from: &str, to: &str| reproducible.split(from).nth(1).unwrap().split(to).next().unwrap();
    let (version, plan) = (between("version ", ","), between("plan ", "."));
    assert!(version.starts_with(concat!(env!("CARGO_PKG_VERSION"), "+")), "{version}");
    let settled = reproducible.replace(version, "VERSION").replace(plan, "PLAN");
    insta::assert_snapshot!("campaign_report", settled);

    let findings = json(&campaign(dir, &["report", "a", "--against", "paper", "--format", "json"]));
    assert_eq!(findings["cells"].as_array().unwrap().len(), 4);
    assert_eq!(findings["cells"][0]["paper"]["table"], 3);
    let table = String::from_utf8(campaign(dir, &["report", "a", "--format", "csv"]).stdout).unwrap();
    assert_eq!(table.lines().count(), 5);
    let picture = String::from_utf8(campaign(dir, &["report", "a", "--format", "svg"]).stdout).unwrap();
    assert!(
        picture.starts_with("<svg") && picture.contains("sandy greedy (0.5, 0.5) in paper-2023"),
        "{picture}"
    );
    // How missions fail stands beside how many do not.
    let mut records = csv::Reader::from_reader(table.as_bytes());
    let headings = records.headers().unwrap().clone();
    let rows: Vec<_> = records.records().map(Result::unwrap).collect();
    for (column, words) in [("deadlock", "out of steps"), ("left_map", "left the map"), ("lost", " lost<")] {
        let at = headings.iter().position(|heading| heading == column).unwrap();
        let need = rows.iter().filter(|row| row[at] != *"0").count();
        assert_eq!(picture.matches(words).count(), need, "{column}: {table}{picture}");
    }
}

/// P-READINGS: Readings of the paper's open points are flown on the same draws, and scored by the
/// likelihood of the paper's numbers.
#[test]
fn readings_of_the_paper_are_flown_beside_each_other_and_scored() {
    let readings = "\n[[readings]]\nname = \"model\"\n\n[[readings]]\nname = \"other\"\nleaving = -100.0\n\
                    distance = \"manhattan\"\nground_at = \"centre\"\nopening_steps = 1\n";
    let dir = folder(&(TINY.to_string() + readings));
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let rows = fs::read_to_string(dir.join("a/trials.jsonl")).unwrap();
    let rows: Vec<serde_json::Value> = rows.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows.len(), 2 * 2 * 2 * 5);
    let of_cell = |cell: u64| rows.iter().filter(move |row| row["cell"] == cell);
    // Scenarios outermost, then readings, then planners: cells 0 and 2 are the MDP's on hard ground.
    let seeds = |cell| of_cell(cell).map(|row| row["seed"].as_u64().unwrap()).collect::<Vec<_>>();
    assert_eq!(seeds(0), seeds(2), "both readings meet the same draws");
    assert!(of_cell(0).zip(of_cell(2)).any(|(model, other)| model["digest"] != other["digest"]));
    for row in of_cell(2).filter(|row| row["outcome"] == "goal") {
        // A hop on hard ground counts two steps, the first observation one.
        assert_eq!(row["steps"].as_u64().unwrap(), 2 * row["hops"].as_u64().unwrap() + 1);
    }
    let scores = json(&campaign(dir, &["report", "a", "--readings", "--format", "json"]));
    assert_eq!(scores["readings"][1]["reading"], "other");
    assert_eq!(scores["readings"][1]["cells"].as_array().unwrap().len(), 4);
    let page = String::from_utf8(campaign(dir, &["report", "a", "--readings"]).stdout).unwrap();
    assert!(page.contains("| other |") && page.contains("## Chosen on two grounds"), "{page}");
    refused(
        dir,
        &["report", "a", "--readings", "--format", "csv"],
        &["--readings needs --format md or json, got csv"],
    );
    let plain = folder(TINY);
    campaign(plain.path(), &["run", "c.toml", "--out", "a"]);
    refused(plain.path(), &["report", "a", "--readings"], &["--readings needs a campaign with [[readings]]"]);
}

/// P-HUNT: Treasures are counted in rows, reports, summaries and pictures.
#[test]
fn treasures_are_counted_row_by_row_and_in_the_report() {
    let text = "name = \"hunt\"\nseed = 3\nrepetitions = 6\nscenarios = [\"treasures\"]\n\
                planners = [\"mdp\", \"greedy\", \"clairvoyant\"]\n";
    let dir = folder(text);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let lines = rows(dir.join("a")).0;
    let counts = lines.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let collected: Vec<u64> = counts.map(|row| row["treasures"].as_u64().unwrap()).collect();
    assert!(collected[..6].iter().all(|count| (1..=4).contains(count)), "{collected:?}");
    let findings = json(&campaign(dir, &["report", "a", "--against", "paper", "--format", "json"]));
    let cell = &findings["cells"][0];
    assert_eq!(cell["treasures"]["mean"].as_f64().unwrap(), collected[..6].iter().sum::<u64>() as f64 / 6.0);
    assert_eq!((&cell["paper"]["table"], &cell["paper"]["treasures"]["mean"]), (&15.into(), &1.93.into()));
    let again = json(&campaign(dir, &["rerun", "a", "--trial", "0", "--out", "r", "--format", "json"]));
    assert_eq!(again["treasures"].as_u64(), Some(collected[0]));
    let picture = fs::read_to_string(dir.join("r/mission.svg")).unwrap();
    assert!(picture.contains("treasure, collected") && picture.contains("treasure, not seen"));
    let shown = json(&done(hopper(&[
        "journal",
        "verify",
        dir.join("r/journal").to_str().unwrap(),
        "--format",
        "json",
    ])));
    assert_eq!(shown["digest"], again["digest"]);
}

/// P-TREASURE-HUNT. In every cell of the paper, at 100 % success. A mission is deterministic, so no
/// chance is involved.
#[test]
fn profile_hopper_collects_more_treasures_than_the_paper_at_no_lower_success() {
    let text = "name = \"hunt\"\nseed = 5\nrepetitions = 60\nscenarios = [\"treasures\"]\n\
                profiles = [\"hopper\"]\nplanners = [\"mdp\"]\nweights = [\n\
                { safety = 1.0, information = 0.0 },\n{ safety = 0.5, information = 0.5 },\n\
                { safety = 0.0, information = 1.0 },\n]\n";
    let dir = folder(text);
    campaign(dir.path(), &["run", "c.toml", "--out", "a"]);
    let report = campaign(dir.path(), &["report", "a", "--against", "paper", "--format", "json"]);
    let cells = json(&report)["cells"].as_array().unwrap().clone();
    assert_eq!(cells.len(), 3);
    for (cell, published) in cells.iter().zip([1.83, 1.93, 2.02]) {
        assert_eq!((&cell["successes"], &cell["trials"]), (&60.into(), &60.into()));
        let mean = |name: &str| cell[name]["mean"].as_f64().unwrap();
        assert!(mean("treasures") > published, "{cell}");
        // Without the search for treasures not yet seen it is 82.
        assert!(mean("restricted_steps") < 80.0, "{cell}");
    }
}

/// P-REGRET: Every report on hoppers with one goal has the regret to the clairvoyant's bounds,
/// which no planner passes; other missions have none.
///
/// No planner passes the clairvoyant's bounds, and the clairvoyant reaches the bound of success.
#[test]
fn every_report_tells_the_regret() {
    let dir = folder(&TINY.replace("\"mdp\", \"greedy\"", "\"mdp\", \"clairvoyant\"").replace("= 5", "= 40"));
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let findings = json(&campaign(dir, &["report", "a", "--format", "json"]));
    for cell in findings["cells"].as_array().unwrap() {
        let (regret, trials) = (&cell["regret"], 40.0_f64);
        let bound = regret["bound"]["success"].as_f64().unwrap();
        assert!(bound > 0.99 && bound <= 1.0, "{cell}");
        let [success, steps] =
            ["success", "restricted_mean_steps"].map(|field| regret[field].as_f64().unwrap());
        let error = cell["restricted_steps"]["sd"].as_f64().unwrap() / trials.sqrt();
        assert!(success > -1e-9 - 3.0 * (bound * (1.0 - bound) / trials).sqrt(), "{cell}");
        assert!(steps > -3.0 * error, "{cell}");
        if cell["planner"] == "clairvoyant" {
            // It reaches the bound of success, whatever that costs in steps.
            assert!(success < 0.1, "{cell}");
        }
    }
}

/// P-REGRET. The bounds are those of a hopper on its way to a goal.
#[test]
fn a_campaign_of_rovers_has_no_regret() {
    let text =
        "name = \"rovers\"\nseed = 3\nrepetitions = 1\nscenarios = [\"coverage\"]\nplanners = [\"spiral\"]\n";
    let dir = folder(text);
    let dir = dir.path();
    campaign(dir, &["run", "c.toml", "--out", "a"]);
    let findings = json(&campaign(dir, &["report", "a", "--format", "json"]));
    assert_eq!(findings["cells"][0]["regret"], Value::Null, "{findings}");
    let table = String::from_utf8(campaign(dir, &["report", "a"]).stdout).unwrap();
    assert!(table.contains("| coverage |") && !table.contains(" points, "), "{table}");
}

/// P-ACCEPT: A campaign compared with another is accepted, or the report exits with code 3.
#[test]
fn one_campaign_beside_another_is_accepted_or_not() {
    let world = |steps_max: u32| {
        let text = include_str!("../scenarios/hard.toml");
        let limited = text.replace("steps_max = 150", &format!("steps_max = {steps_max}"));
        assert!(steps_max == 150 || limited != text);
        limited
    };
    let campaign_text = "name = \"NAME\"\nseed = 3\nrepetitions = 6\nscenarios = [\"world.toml\"]\n\
                         planners = [\"mdp\", \"greedy\"]\n";
    let dir = tempfile::tempdir().unwrap();
    for (name, steps_max) in [("long", 150), ("short", 60)] {
        let own = dir.path().join(name);
        fs::create_dir(&own).unwrap();
        fs::write(own.join("world.toml"), world(steps_max)).unwrap();
        fs::write(own.join("c.toml"), campaign_text.replace("NAME", name)).unwrap();
        campaign(&own, &["run", "c.toml", "--out", "rows"]);
    }
    let beside = |ours: &str, other: &str, more: &[&str]| {
        let words = [&["campaign", "report", ours, "--beside", other][..], more].concat();
        hopper(&words).current_dir(dir.path()).output().unwrap()
    };
    let same = beside("long/rows", "long/rows", &["--accept", "--format", "markdown"]);
    assert_eq!(same.status.code(), Some(0), "{}", stderr(&same));
    let text = String::from_utf8(same.stdout).unwrap();
    assert!(
        text.contains("| `long` | restricted |") && text.contains("1 of 1 cells of the MDP are accepted"),
        "{text}"
    );
    assert_eq!(
        beside("short/rows", "long/rows", &[]).status.code(),
        Some(0),
        "only --accept makes it a threshold"
    );
    let missed = beside("short/rows", "long/rows", &["--accept", "--format", "json"]);
    assert_eq!(missed.status.code(), Some(3));
    let comparison: Value = serde_json::from_slice(&missed.stdout).unwrap();
    assert_eq!(comparison["cells"][0]["verdict"]["missed"][0], "success below the other's");
    assert_eq!(comparison["cells"][1]["verdict"], Value::Null, "greedy is not judged");
    refused(
        dir.path(),
        &["report", "long/rows", "--beside", "long/rows", "--format", "svg"],
        &["--beside needs"],
    );
    refused(dir.path(), &["report", "long/rows", "--accept"], &["--beside"]);
}

/// P-CAMPAIGNS: Every campaign in `campaigns/` is valid.
#[test]
fn the_campaigns_of_the_house_are_sound() {
    // Flies those of studies.
    harness::program("hopper-research");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("campaigns");
    let dir = tempfile::tempdir().unwrap();
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // One trial of so many shards is enough to know.
        let out = dir.path().join(path.file_stem().unwrap());
        let words = ["run", path.to_str().unwrap(), "--shard", "3000/3000", "--out", out.to_str().unwrap()];
        campaign(dir.path(), &words);
        count += 1;
    }
    assert_eq!(count, 14);
}
