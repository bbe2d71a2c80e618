//! Somebody deletes, replaces or cuts the files of a live mission, or starts another in its folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::harness::{self, Mission, Process, eventually, lockstep, stderr};
use rustix::process::Signal;

/// `hopper run` into `out` of the mission's folder, with an instance of its own.
fn start_run(mission: &Mission, words: &[&str]) -> Process {
    let mut command =
        mission.hopper(&["run", "--instance", &mission.name, "--out", "out", "--format", "json"]);
    command.args(words);
    Process::spawn("run", command, &mission.path(""))
}

fn journal_file(dir: &Path) -> PathBuf {
    dir.join("hops.journal")
}

/// Waits until the journal in `dir` holds `count` decisions.
fn await_decisions(dir: &Path, count: u64) {
    eventually("decisions", || {
        journal_file(dir).exists() && harness::verify(dir)["decisions"].as_u64() >= Some(count)
    });
}

/// What is in a folder but its journal, which grows.
fn contents(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let files = fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file());
    files.map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

/// P-REFUSED: A run that is refused because its directory is in use exits with code 4, writes
/// nothing there, and reports nothing as flown.
#[test]
fn a_run_that_is_refused_touches_nothing_of_a_live_mission() {
    let mission = Mission::new("refused");
    let out = mission.path("out");
    let mut run = start_run(&mission, &["--seed", "71", "--pace", "2"]);
    await_decisions(&out.join("journal"), 1);
    let before = contents(&out);
    let other = Mission::new("refused-too");
    let second = ["run", "--instance", &other.name, "--out", out.to_str().unwrap(), "--seed", "71"];
    for words in [&second[..], &[&second[..], &["--lockstep"]].concat()] {
        let output = other.hopper(words).output().unwrap();
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        let told = format!("is in use by process {}: name another folder", run.pid());
        assert!(stderr(&output).contains(&told), "{}", stderr(&output));
        assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
        assert_eq!(contents(&out), before);
    }
    run.signal(Signal::TERM);
    assert_eq!(run.code(), 130, "{}", run.log());

    // The folder of a hopper-sim that was started by hand, even with its lock file removed.
    let sim = mission.start("sim", &["--seed", "71", "--journal", "by-hand/journal"]);
    sim.await_log("joined");
    fs::remove_file(mission.path("by-hand/journal/lock")).unwrap();
    let by_hand = mission.path("by-hand");
    let words = ["run", "--instance", &other.name, "--out", by_hand.to_str().unwrap(), "--seed", "71"];
    let output = other.hopper(&words).output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains(&format!("held by process {}", sim.pid())), "{}", stderr(&output));
    let names = |dir: &Path| -> Vec<_> {
        fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().file_name()).collect()
    };
    assert_eq!(names(&by_hand), ["journal"]);
    assert_eq!(names(&by_hand.join("journal")), ["hops.journal"]);
}

/// P-LOCK-FILE. A second hopper-sim in another instance, with the lock file removed.
#[test]
fn a_second_simulator_is_refused_though_the_lock_file_is_gone() {
    let mission = Mission::new("unlocked");
    let first = mission.start("sim", &[]);
    first.await_log("joined");
    fs::remove_file(mission.journal().join("lock")).unwrap();
    let other = Mission::new("unlocked-too");
    let journal = mission.journal();
    let mut second = other.start("sim", &["--journal", journal.to_str().unwrap()]);
    assert_eq!(second.code(), 4, "{}", second.log());
    assert!(second.log().contains(&format!("held by process {}", first.pid())), "{}", second.log());
}

/// P-RESUME-ONLY: A hopper-sim that `hopper run` restarts resumes the journal of its run with all
/// published decisions, or the mission ends with exit code 1. It never starts over.
#[test]
fn a_restarted_simulator_never_begins_its_run_anew() {
    type Tamper = fn(&Path, &[u8]);
    let cases: [(&str, Tamper, &str); 3] = [
        ("deleted", |dir, _| fs::remove_dir_all(dir).unwrap(), "got no file"),
        (
            "shortened",
            |dir, early| {
                let aside = dir.join("aside");
                fs::write(&aside, early).unwrap();
                fs::rename(aside, journal_file(dir)).unwrap();
            },
            "decisions that were published, got 1",
        ),
        (
            "another run's",
            |dir, _| {
                fs::remove_dir_all(dir).unwrap();
                let out = dir.parent().unwrap().join("other");
                let words = ["run", "--lockstep", "--seed", "72", "--out", out.to_str().unwrap()];
                assert!(harness::hopper(&words).output().unwrap().status.success());
                fs::rename(out.join("journal"), dir).unwrap();
            },
            "run needs ",
        ),
    ];
    for (case, tamper, told) in cases {
        let mut mission = Mission::new("anew");
        let journal = mission.path("out/journal");
        let mut run = start_run(&mission, &["--seed", "72", "--pace", "4"]);
        await_decisions(&journal, 1);
        let early = fs::read(journal_file(&journal)).unwrap();
        let early = &early[..early.len().min(first_record_end(&early))];
        await_decisions(&journal, 4);
        // Heartbeats say what was published.
        std::thread::sleep(Duration::from_millis(200));
        tamper(&journal, early);
        let tampered = fs::read(journal_file(&journal)).ok();
        run.kill_child("sim");
        assert_eq!(run.code(), 1, "{case}: {}", run.log());
        assert!(run.log().contains("cannot be resumed") && run.log().contains(told), "{case}: {}", run.log());
        assert_eq!(run.out(), "", "{case}: nothing is reported as flown");
        assert!(!mission.path("out/summary.json").exists(), "{case}");
        assert_eq!(fs::read(journal_file(&journal)).ok(), tampered, "{case}: nothing is flown");
        mission.assert_nothing_left();
    }
}

/// Where the first record of a journal ends, bytes.
fn first_record_end(journal: &[u8]) -> usize {
    let frame_end = |at: usize| {
        let length = u32::from_le_bytes(journal[at..at + 4].try_into().unwrap());
        at + 8 + length as usize
    };
    // Magic and format stand before the frames of version and header.
    frame_end(frame_end(frame_end(12)))
}

/// P-DISPLACED-LIVE: A running hopper-sim whose journal is deleted, replaced or cut holds at once
/// and says so once. If the file is put back it continues; when its patience ends, also after the
/// mission's last decision, it exits with code 1 without a summary.
#[test]
fn a_simulator_whose_journal_goes_holds_says_so_and_gives_up() {
    type Tamper = fn(&Path);
    let cases: [(&str, Tamper); 3] = [
        ("was deleted or moved away", |file| fs::remove_file(file).unwrap()),
        ("was replaced by another file", |file| {
            let copy = file.with_extension("copy");
            fs::copy(file, &copy).unwrap();
            fs::rename(copy, file).unwrap();
        }),
        ("was cut from", |file| {
            let bytes = fs::metadata(file).unwrap().len();
            fs::OpenOptions::new().write(true).open(file).unwrap().set_len(bytes / 2).unwrap();
        }),
    ];
    for (told, tamper) in cases {
        let mission = Mission::new("displaced");
        let mut sim = mission.start("sim", &["--seed", "73", "--pace", "4", "--patience", "700ms"]);
        let peers = mission.start_peers();
        mission.await_decisions(2);
        tamper(&journal_file(&mission.journal()));
        assert_eq!(sim.code(), 1, "{told}: {}", sim.log());
        assert_eq!(sim.log().matches("holding at decision").count(), 1, "{told}: {}", sim.log());
        assert!(sim.log().contains(told) && sim.log().contains("held for 700ms"), "{told}: {}", sim.log());
        assert_eq!(sim.out(), "", "{told}: no outcome is reported");
        drop(peers);
    }
}

/// P-DISPLACED-LIVE. The end of a mission is not reported if its journal is gone.
#[test]
fn a_finished_mission_without_its_journal_is_no_success() {
    let mission = Mission::new("nothing-to-show");
    let words = ["run", "--lockstep", "--out", ".", "--seed", "74"];
    assert!(mission.hopper(&words).output().unwrap().status.success());
    let mut sim = mission.start("sim", &["--seed", "74", "--linger", "1s", "--patience", "500ms"]);
    sim.await_log("joined");
    fs::remove_file(journal_file(&mission.journal())).unwrap();
    assert_eq!(sim.code(), 1, "{}", sim.log());
    assert!(sim.log().contains("was deleted or moved away"), "{}", sim.log());
}

/// P-DISPLACED-LIVE. If the journal is put back in time, the mission continues to the undisturbed
/// digest.
#[test]
fn a_journal_that_is_put_back_is_gone_on_with() {
    let mut mission = Mission::new("put-back");
    let mut sim = mission.start("sim", &["--seed", "75", "--pace", "20"]);
    let mut peers = mission.start_peers();
    mission.await_decisions(2);
    let (file, aside) = (journal_file(&mission.journal()), mission.path("aside"));
    fs::rename(&file, &aside).unwrap();
    sim.await_log("holding at decision");
    fs::rename(&aside, &file).unwrap();
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!(sim.json()["digest"], lockstep(&["--seed", "75"])["digest"]);
    peers.iter_mut().for_each(|peer| assert_eq!(peer.code(), 0, "{}", peer.log()));
    mission.assert_nothing_left();
}

/// P-PAST-LOST: A past that cannot be served is reported once by hopper-sim and once by each
/// process that asks for it, and ends the mission when patience does.
#[test]
fn a_past_that_cannot_be_served_is_said_once_and_ends() {
    let mission = Mission::new("no-past");
    let mut sim = mission.start("sim", &["--seed", "76", "--pace", "4", "--patience", "2s"]);
    let mut perception = mission.start("perception", &[]);
    let _planner = mission.start("planner", &[]);
    mission.await_decisions(3);
    let file = fs::OpenOptions::new().write(true).open(journal_file(&mission.journal())).unwrap();
    file.set_len(1_000).unwrap();
    perception.kill();
    let perception = mission.start("perception", &[]);
    assert_eq!(sim.code(), 1, "{}", sim.log());
    assert_eq!(sim.log().matches("the past cannot be served").count(), 1, "{}", sim.log());
    assert!(sim.log().lines().count() < 12, "{}", sim.log());
    assert!(perception.log().lines().count() < 12, "{}", perception.log());
}

/// P-NOT-SOUND. A header that contradicts its scenario, with right checksums.
#[test]
fn whoever_reads_a_journal_with_a_changed_header_says_so_first() {
    type Twist = fn(&mut hopper_sim::JournalHeader);
    let cases: [(Twist, &str, &str); 3] = [
        // Another ground.
        (
            |header| header.resolved = header.resolved.replace("amplitude_m = 0.159", "amplitude_m = 0.959"),
            "header: brief.scenario_hash needs",
            "amplitude_m needs 0.15915494309189535, got 0.9591549430918953",
        ),
        (
            |header| {
                let contract::Body::Hopper(hopper) = &mut header.brief.robots[0].body else {
                    unreachable!("a hopper")
                };
                hopper.motion.gravity_mps2 = 9.81;
            },
            "header: brief.robots.0.body.motion.gravity_mps2 needs 3.72, got 9.81",
            "brief.robots.0.body.motion.gravity_mps2 needs 3.72, got 9.81",
        ),
        (|header| header.brief.grid.width += 1, "header: brief.grid.width needs", "brief.grid.width needs"),
    ];
    let mission = Mission::new("header");
    let flown = mission.hopper(&["run", "--lockstep", "--seed", "3", "--out", "."]).output().unwrap();
    assert!(flown.status.success(), "{}", stderr(&flown));
    for (number, (twist, verified, resumed)) in cases.into_iter().enumerate() {
        let out = format!("forged-{number}");
        let history = hopper_sim::JournalReader::open(&mission.journal()).unwrap();
        let mut header = history.header().clone();
        twist(&mut header);
        assert_ne!(&header, history.header(), "{verified}");
        let journal = mission.path(&out).join("journal");
        let mut forged = hopper_sim::Journal::create(&journal, &header, false).unwrap();
        history.records().take(8).for_each(|record| forged.append(&record.unwrap(), None).unwrap());
        drop(forged);
        for words in [&["journal", "verify", &out][..], &["journal", "verify", &out, "--against-lockstep"]] {
            let output = mission.hopper(words).output().unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            assert_eq!(output.status.code(), Some(1), "{words:?}: {text}");
            assert!(text.contains("NOT SOUND") && text.contains(verified), "{words:?}: {text}");
        }
        for (words, told) in [
            (&["journal", "draw", &out][..], verified),
            (&["view", &out, "--web", "127.0.0.1:0"], verified),
            (&["run", "--lockstep", "--planners-from", &out, "--out", "again"], verified),
            (&["run", "--lockstep", "--seed", "3", "--out", &out], resumed),
            (&["run", "--seed", "3", "--instance", &mission.name, "--out", &out], resumed),
        ] {
            let output = mission.hopper(words).output().unwrap();
            let text = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{words:?}: {text}");
            assert!(text.contains(told) && text.len() < 1000, "{words:?}: {text}");
        }
    }
}
