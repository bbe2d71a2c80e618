//! What journals of each kind of mission are called, and that each is read back as it was written.

use contract::{Brief, Limits, RunId};
use hopper_sim::journal::FILE_NAME;
use hopper_sim::{Journal, JournalError, JournalHeader, JournalReader};
use scenario::ResolvedScenario;
use tempfile::tempdir;

fn world(scenario: &str) -> ResolvedScenario {
    scenario::load(scenario).unwrap().resolve().unwrap()
}

fn header(scenario: &str) -> JournalHeader {
    JournalHeader::new(&world(scenario), 7).with_run(RunId(5))
}

/// P-JOURNAL-FORMATS.
#[test]
fn a_journal_of_each_kind_of_mission_has_its_format_and_is_read_back_whole() {
    let formats =
        [("hard", 5_u32), ("coverage", 6), ("rover-helicopter", 7), ("hopper-scout", 8), ("expedition", 10)];
    for (scenario, format) in formats {
        let (dir, header) = (tempdir().unwrap(), header(scenario));
        drop(Journal::create(dir.path(), &header, false).unwrap());
        let bytes = std::fs::read(dir.path().join(FILE_NAME)).unwrap();
        assert_eq!(bytes[8..12], format.to_le_bytes(), "{scenario}");
        assert_eq!(JournalReader::open(dir.path()).unwrap().header(), &header, "{scenario}");
        let again = Journal::resume_run(dir.path(), &header, &world(scenario).terrain, false).unwrap();
        assert_eq!((again.header(), again.is_empty(), again.len()), (&header, true, 0), "{scenario}");
    }
}

/// P-OLD-JOURNAL: its header is what this build makes of its scenario, and each record comes out the same again.
#[test]
fn a_journal_of_the_release_before_is_sound() {
    let golden = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden/hard-journal");
    let verification = hopper_sim::verify(&golden).unwrap();
    assert_eq!((verification.faults(), verification.unrepeated.clone()), (vec![], None), "{verification}");
    assert_eq!(verification.decisions, 37);
}

/// P-STAGES-FORMAT: only a mission of several stages has their number in its journal; one of one stage is as it was before there were
/// any.
#[test]
fn a_journal_of_several_stages_has_a_format_of_its_own() {
    let dir = tempdir().unwrap();
    let written = |name: &str, stages: u32| {
        let mut header = header("rover-helicopter");
        header.brief.scout.as_mut().unwrap().stages = stages;
        let dir = dir.path().join(name);
        drop(Journal::create(&dir, &header, false).unwrap());
        assert_eq!(JournalReader::open(&dir).unwrap().header(), &header, "{name}");
        let ground = world("rover-helicopter").terrain;
        assert_eq!(Journal::resume_run(&dir, &header, &ground, false).unwrap().header(), &header, "{name}");
        std::fs::read(dir.join(FILE_NAME)).unwrap()
    };
    let (one, three) = (written("one", 1), written("three", 3));
    assert_eq!((one[8..12].to_vec(), three[8..12].to_vec()), (vec![7, 0, 0, 0], vec![9, 0, 0, 0]));
    assert_eq!(three.len(), one.len() + size_of::<u32>());
}

#[test]
fn a_journal_is_resumed_with_another_budget_and_not_as_another_run() {
    let (dir, written) = (tempdir().unwrap(), header("hard"));
    assert!(!Journal::exists(dir.path()));
    drop(Journal::create(dir.path(), &written, false).unwrap());
    assert!(Journal::exists(dir.path()));
    let limits = Limits { decision_budget_ns: 1, ..written.brief.limits };
    let hurried = JournalHeader { brief: Brief { limits, ..written.brief }, ..written.clone() };
    drop(Journal::resume_run(dir.path(), &hurried, &world("hard").terrain, false).unwrap());
    let stranger = written.with_run(RunId(6));
    let error = Journal::resume_run(dir.path(), &stranger, &world("hard").terrain, false).unwrap_err();
    assert!(matches!(&error, JournalError::Mismatch { field, .. } if field == "run"), "{error}");
}

#[test]
fn whoever_holds_a_journal_is_named_and_lets_go_of_it_at_its_end() {
    let (dir, header) = (tempdir().unwrap(), header("hard"));
    let held = Journal::create(dir.path(), &header, false).unwrap();
    let error = Journal::resume(dir.path(), &header, &world("hard").terrain, false).unwrap_err();
    assert!(error.to_string().contains(&std::process::id().to_string()), "{error}");
    drop(held);
    drop(Journal::resume(dir.path(), &header, &world("hard").terrain, false).unwrap());
}
