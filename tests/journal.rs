//! hopper-sim on journals that are finished, foreign, torn or damaged.

use crate::harness::{Mission, Process, hopper, json, stderr};
use serde_json::Value;

/// Flies a whole mission into the mission's `journal`, in lockstep.
fn flown(mission: &Mission, seed: &str) -> Value {
    let output = mission
        .hopper(&["run", "--lockstep", "--out", ".", "--format", "json", "--seed", seed])
        .output()
        .unwrap();
    json(&output)
}

fn journal_file(mission: &Mission) -> std::path::PathBuf {
    mission.journal().join("hops.journal")
}

/// P-FINISHED: A finished journal is served to late peers; with no peers, serving ends after the
/// linger time.
#[test]
fn a_finished_journal_is_served_to_late_comers() {
    let mut mission = Mission::new("finished");
    let flown = flown(&mission, "31");
    let mut peers = mission.start_peers();
    let mut sim = mission.start("sim", &["--seed", "31"]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!(sim.json()["digest"], flown["digest"]);
    assert_eq!(sim.json()["decisions"], flown["decisions"], "nothing more is executed");
    for peer in &mut peers {
        assert_eq!(peer.code(), 0, "{}", peer.log());
    }
    mission.assert_nothing_left();
}

/// P-FINISHED. Without peers hopper-sim serves the end for the linger time and exits.
#[test]
fn a_finished_journal_with_nobody_there_ends_after_its_linger() {
    let mission = Mission::new("alone");
    flown(&mission, "31");
    let mut sim = mission.start("sim", &["--seed", "31", "--linger", "200ms"]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
}

/// P-FOREIGN: A journal of another mission is refused, and the error names the field, what was
/// needed and what was found.
#[test]
fn a_foreign_journal_is_refused_by_name() {
    let mission = Mission::new("foreign");
    flown(&mission, "31");
    for (words, field, got) in [
        (&["--seed", "32"][..], "seed", "31"),
        (&["--seed", "31", "--scenario", "sandy"], "scenario", "hard"),
        (&["--seed", "31", "--profile", "hopper"], "profile", "paper-2023"),
    ] {
        let mut sim = mission.start("sim", words);
        assert_eq!(sim.code(), 2, "{}", sim.log());
        assert!(sim.log().contains(field) && sim.log().contains(got), "{words:?}: {}", sim.log());
    }
}

/// P-TORN: A torn tail of the journal is cut off, and the mission continues to the undisturbed
/// digest.
#[test]
fn a_torn_journal_is_cut_and_resumed() {
    let whole = Mission::new("whole");
    let digest = flown(&whole, "33")["digest"].clone();
    let bytes = std::fs::read(journal_file(&whole)).unwrap();
    for cut in [bytes.len() - 1, bytes.len() - 200, bytes.len() / 2, bytes.len() / 3] {
        let mission = Mission::new("torn");
        std::fs::create_dir_all(mission.journal()).unwrap();
        std::fs::write(journal_file(&mission), &bytes[..cut]).unwrap();
        let _peers = mission.start_peers();
        let mut sim = mission.start("sim", &["--seed", "33"]);
        assert_eq!(sim.code(), 0, "cut at {cut}: {}", sim.log());
        assert_eq!(sim.json()["digest"], digest, "cut at {cut}");
        assert_eq!(mission.verified()["duplicates"], 0);
    }
}

/// P-DAMAGE: A journal that is damaged before its tail is refused, with one exit code by all that
/// read it.
#[test]
fn a_damaged_journal_is_refused() {
    let mission = Mission::new("damaged");
    flown(&mission, "33");
    let mut bytes = std::fs::read(journal_file(&mission)).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x40;
    std::fs::write(journal_file(&mission), bytes).unwrap();
    let mut sim = mission.start("sim", &["--seed", "33"]);
    assert_eq!(sim.code(), 2, "{}", sim.log());
    for words in [
        &["journal", "verify"][..],
        &["journal", "show"],
        &["journal", "draw"],
        &["view", "--web", "127.0.0.1:0"],
    ] {
        let output = mission.hopper(&[words, &["journal"]].concat()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("is corrupt"), "{words:?}: {}", stderr(&output));
    }
}

/// P-LOCK: A journal in use is refused, and the error names the process that holds it.
#[test]
fn a_journal_in_use_is_refused_naming_its_holder() {
    let mission = Mission::new("locked");
    let first = mission.start("sim", &[]);
    first.await_log("joined");
    let command =
        mission.hopper(&["sim", "--instance", &format!("{}-b", mission.name), "--journal", "journal"]);
    let mut second = Process::spawn("second", command, &mission.path(""));
    assert_eq!(second.code(), 4, "{}", second.log());
    assert!(second.log().contains(&first.pid().to_string()), "{}", second.log());
    let _ = hopper(&["doctor", "--clean", "--instance", &format!("{}-b", mission.name)]).output();
}

/// P-LOCKSTEP-FRESH: Lockstep never appends to another run's records.
#[test]
fn lockstep_refuses_a_folder_that_holds_a_journal() {
    let mission = Mission::new("again");
    flown(&mission, "31");
    let before = std::fs::read(journal_file(&mission)).unwrap();
    let output = mission.hopper(&["run", "--lockstep", "--out", ".", "--seed", "32"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("seed needs 32, got 31"), "{}", stderr(&output));
    // Of the same mission nothing is left to fly.
    let output = mission.hopper(&["run", "--lockstep", "--out", ".", "--seed", "31"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("already ended"), "{}", stderr(&output));
    assert!(std::fs::read(journal_file(&mission)).unwrap() == before);
}

/// P-VERIFY: `journal verify` and `journal show` agree with the summary.
#[test]
fn verify_and_show_agree_with_the_summary() {
    let mission = Mission::new("verify");
    let summary = flown(&mission, "31");
    let verified = mission.verified();
    for field in ["decisions", "digest", "outcome"] {
        assert_eq!(verified[field], summary[field], "{field}");
    }
    assert_eq!(verified["contiguous"], true);
    let output = hopper(&["journal", "show", mission.journal().to_str().unwrap(), "--format", "json"])
        .output()
        .unwrap();
    let shown = json(&output);
    let records = shown["records"].as_array().unwrap();
    assert_eq!(records.len() as u64, summary["decisions"].as_u64().unwrap());
    assert_eq!(records.last().unwrap()["digest"], summary["digest"]);
}

/// P-OUT. A directory of another mission is refused before anything in it is overwritten.
#[test]
fn another_missions_folder_is_left_as_it_was() {
    let mission = Mission::new("theirs");
    flown(&mission, "31");
    let before = std::fs::read_to_string(mission.path("scenario.toml")).unwrap();
    let output =
        mission.hopper(&["run", "--out", ".", "--scenario", "sandy", "--seed", "9"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(mission.path("scenario.toml")).unwrap(), before);
}

/// P-LOCKSTEP-MAPS.
#[test]
fn a_decision_on_a_wrong_map_is_found_though_the_digest_is_right() {
    let mission = Mission::new("maps");
    flown(&mission, "31");
    mission.assert_as_lockstep("journal");
    let history = hopper_sim::JournalReader::open(&mission.journal()).unwrap();
    let mut forged =
        hopper_sim::Journal::create(&mission.path("forged"), &history.header().clone(), false).unwrap();
    for record in history.records() {
        let record = record.unwrap();
        let observation = record.observation ^ u64::from(record.decision.0 == 5);
        forged.append(&contract::Record { observation, ..record }, None).unwrap();
    }
    drop(forged);
    let verify = |words: &[&str]| {
        let output = mission.hopper(&[&["journal", "verify", "forged"], words].concat()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    assert_eq!(verify(&[]).0, Some(0), "the chain is sound");
    let (code, text) = verify(&["--against-lockstep"]);
    assert!(code == Some(1) && text.contains("decision 5") && text.contains("wrong map"), "{text}");
    let (code, text) = verify(&["--against-lockstep", "--format", "json"]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, &answer["difference"]["decision"]), (Some(1), &5.into()), "{text}");
    let words = ["run", "--lockstep", "--planners-from", "forged", "--out", "again"];
    let output = mission.hopper(&words).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("wrong map"), "{}", stderr(&output));
}

/// P-NOT-SOUND. Visits are in no digest, so the digest chain of the changed journal still holds.
#[test]
fn whoever_reads_a_journal_that_is_not_sound_says_so_first() {
    let mission = Mission::new("unsound");
    flown(&mission, "31");
    let history = hopper_sim::JournalReader::open(&mission.journal()).unwrap();
    let mut forged =
        hopper_sim::Journal::create(&mission.path("forged"), &history.header().clone(), false).unwrap();
    for record in history.records().map(Result::unwrap) {
        let visits = record.visits + u64::from(record.decision.0 == 5);
        forged.append(&contract::Record { visits, ..record }, None).unwrap();
    }
    drop(forged);
    let told = "record 5: visits needs 0, got 1";
    for words in
        [&["journal", "verify", "forged"][..], &["journal", "verify", "forged", "--against-lockstep"]]
    {
        let output = mission.hopper(words).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(1), "{words:?}: {text}");
        assert!(text.contains("NOT SOUND") && text.contains(told), "{words:?}: {text}");
        assert!(!text.contains("the same digest"), "{words:?}: {text}");
    }
    for words in [
        &["journal", "draw", "forged"][..],
        &["view", "forged", "--web", "127.0.0.1:0"],
        &["run", "--lockstep", "--planners-from", "forged", "--out", "again"],
    ] {
        let output = mission.hopper(words).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        let text = stderr(&output);
        assert!(text.contains("NOT SOUND") && text.contains(told), "{words:?}: {text}");
    }
    let mut sim = mission.start("sim", &["--seed", "31", "--journal", "forged"]);
    assert_eq!(sim.code(), 2, "{}", sim.log());
    assert!(sim.log().contains("NOT SOUND") && sim.log().contains(told), "{}", sim.log());
}

/// P-JOURNAL-DRAW: `hopper journal draw` draws a mission again at any decision, the last one as
/// `hopper run` drew it.
#[test]
fn a_mission_is_drawn_again_as_it_was_and_at_any_decision() {
    let mission = Mission::new("drawn");
    let flown = flown(&mission, "31");
    let read = |file: &str| std::fs::read_to_string(mission.path(file)).unwrap();
    let draw = |words: &[&str]| {
        let output = mission.hopper(&[&["journal", "draw", "."], words].concat()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
    };
    draw(&["--out", "again.svg"]);
    assert!(read("again.svg") == read("mission.svg"), "the same picture, to the byte");
    draw(&["--at", "5", "--picture", "paper", "--out", "early.svg"]);
    assert!(read("early.svg").contains("width=\"85mm\""));
    let beyond = flown["decisions"].as_u64().unwrap() + 1;
    let output = mission.hopper(&["journal", "draw", ".", "--at", &beyond.to_string()]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains(&format!("got {beyond}")), "{}", stderr(&output));
}
