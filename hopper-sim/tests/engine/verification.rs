//! What `hopper journal verify` finds, and what it is not fooled by.

use contract::{Decision, Digest, Name, Record, Status, Term};
use hopper_sim::journal::Show;
use hopper_sim::{Journal, JournalError, Mission, Pace, ROBOT, Verification, verify};
use report::Leadership;

use crate::fixture::{Host, header, mission, name, undisturbed};
use crate::journal::Written;

fn leadership(name: Name, term: u64, from: u64, to: u64) -> Leadership {
    Leadership {
        name,
        term: Term(term),
        from_decision: Decision(from),
        to_decision: Decision(to),
        robot: ROBOT,
    }
}

/// The undisturbed records, with terms and planners as `leader` gives them.
fn led_by(leader: impl Fn(u64) -> (&'static str, u64)) -> Vec<Record> {
    let mut records = undisturbed();
    for record in &mut records {
        let (planner, term) = leader(record.decision.0);
        record.leader.planner = name(planner);
        record.leader.term = Term(term);
    }
    records
}

#[test]
fn a_sound_journal_is_told_in_full() {
    let written = Written::of(led_by(|decision| if decision < 4 { ("mdp", 1) } else { ("greedy", 2) }));
    let records = &written.records;
    let verification = verify(written.path()).unwrap();
    assert!(verification.is_sound());
    let last = records.last().unwrap();
    assert_eq!(
        verification,
        Verification {
            run: mission().brief.run,
            scenario: name("bench"),
            seed: 42,
            profile: contract::Profile::Hopper,
            decisions: records.len() as u64,
            contiguous: true,
            duplicates: 0,
            digest: last.digest,
            digest_broken_at: None,
            outcome: last.status,
            steps: last.steps,
            after_the_end: 0,
            terms_rise: true,
            fault: None,
            unrepeated: verification.unrepeated.clone(),
            vetoes: 0,
            fallbacks: report::Fallbacks::default(),
            torn_bytes: 0,
            planners: vec![
                leadership(name("mdp"), 1, 0, 3),
                leadership(name("greedy"), 2, 4, last.decision.0)
            ],
            commander: last.leader.incarnation,
        }
    );
}

#[test]
fn an_empty_journal_is_sound_and_underway() {
    let verification = verify(Written::of(vec![]).path()).unwrap();
    assert!(verification.is_sound());
    assert_eq!((verification.decisions, verification.outcome), (0, Status::Underway));
    assert_eq!(verification.digest, mission().genesis());
}

#[test]
fn a_torn_tail_is_counted_and_not_cut() {
    let written = Written::new();
    let mut bytes = written.bytes();
    bytes.truncate(bytes.len() - 1);
    written.overwrite(&bytes);
    let verification = verify(written.path()).unwrap();
    let last = written.records.len() - 1;
    assert_eq!(verification.torn_bytes, written.frame(last).len() as u64 - 1);
    assert_eq!(verification.digest, written.records[last - 1].digest);
    assert!(verification.is_sound(), "what was not wholly written did not happen");
    assert_eq!(written.bytes(), bytes);
}

#[test]
fn a_journal_may_be_verified_while_it_is_written() {
    let written = Written::of(undisturbed()[..3].to_vec());
    let mut journal = Journal::open(written.path(), false).unwrap();
    journal.append(&undisturbed()[3], None).unwrap();
    assert_eq!(verify(written.path()).unwrap().decisions, 4);
}

#[test]
fn a_doubled_record_is_a_duplicate_and_a_missing_one_a_gap() {
    let written = Written::new();
    let bytes = written.bytes();
    let frame = written.frame(4);
    written.overwrite(&[&bytes[..frame.end], &bytes[frame.start..]].concat());
    let doubled = verify(written.path()).unwrap();
    assert_eq!((doubled.duplicates, doubled.contiguous), (1, true));
    assert_eq!(
        (doubled.decisions, doubled.digest_broken_at),
        (written.records.len() as u64, Some(Decision(4)))
    );
    written.overwrite(&[&bytes[..frame.start], &bytes[frame.end..]].concat());
    let missing = verify(written.path()).unwrap();
    assert_eq!((missing.duplicates, missing.contiguous), (0, false));
    assert_eq!(missing.digest_broken_at, Some(Decision(5)));
    assert!(!doubled.is_sound() && !missing.is_sound());
}

#[test]
fn a_record_that_belies_its_digest_breaks_the_chain() {
    let mut records = undisturbed();
    records[3].steps += 1;
    let verification = verify(Written::of(records).path()).unwrap();
    assert_eq!(verification.digest_broken_at, Some(Decision(3)));
    assert!(!verification.is_sound());
}

#[test]
fn the_records_of_another_seed_do_not_pass() {
    let foreign = Mission { seed: 43, ..mission() };
    let genuine = Written::of(vec![]);
    let mut host = Host::new(foreign.clone(), Vec::new(), Pace::Max);
    let other = tempfile::tempdir().unwrap();
    let mut journal = Journal::create(other.path(), &header(&foreign), false).unwrap();
    let header_bytes = std::fs::read(other.path().join(hopper_sim::journal::FILE_NAME)).unwrap().len();
    for record in &host.fly().records {
        journal.append(record, None).unwrap();
    }
    let foreign_bytes = std::fs::read(other.path().join(hopper_sim::journal::FILE_NAME)).unwrap();
    genuine.overwrite(&[&genuine.bytes()[..], &foreign_bytes[header_bytes..]].concat());
    assert_eq!(verify(genuine.path()).unwrap().digest_broken_at, Some(Decision(0)));
    let error = Journal::open(genuine.path(), false).unwrap_err();
    assert!(matches!(error, JournalError::BrokenChain { decision: Decision(0), .. }), "{error}");
}

#[test]
fn a_term_that_falls_or_changes_hands_is_noticed() {
    for leader in [
        |decision| if decision < 4 { ("mdp", 2) } else { ("greedy", 1) },
        |decision| if decision < 4 { ("mdp", 1) } else { ("greedy", 1) },
        |_| ("mdp", 0),
    ] {
        let verification = verify(Written::of(led_by(leader)).path()).unwrap();
        assert!(!verification.terms_rise && !verification.is_sound());
        assert_eq!(verification.digest_broken_at, None, "terms are not in the chain");
    }
}

#[test]
fn records_after_the_end_are_noticed() {
    let mut records = undisturbed();
    let last = *records.last().unwrap();
    let mut more = Record { decision: last.decision.next(), previous: last.digest, ..last };
    more.digest = more.previous.chain(&more);
    records.push(more);
    let verification = verify(Written::of(records).path()).unwrap();
    assert_eq!((verification.after_the_end, verification.is_sound()), (1, false));
}

#[test]
fn damage_in_the_middle_is_an_error() {
    let written = Written::new();
    let mut bytes = written.bytes();
    bytes[written.frame(2).start + 20] ^= 1;
    written.overwrite(&bytes);
    assert!(matches!(verify(written.path()), Err(JournalError::Corrupt { .. })));
}

#[test]
fn the_json_has_the_promised_fields_and_the_shown_records() {
    let written = Written::new();
    let show = Show::new(written.path()).unwrap();
    let text = serde_json::to_string(&show).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["decisions"], written.records.len());
    assert_eq!((&json["contiguous"], &json["duplicates"]), (&true.into(), &0.into()));
    assert_eq!(json["outcome"], show.verification.outcome.as_str());
    assert_eq!(json["digest"].as_str().unwrap().parse::<Digest>().unwrap(), show.verification.digest);
    for field in ["name", "term", "from_decision", "to_decision"] {
        assert!(!json["planners"][0][field].is_null(), "{field}");
    }
    assert!(text.contains(&format!("\"records\":{}", serde_json::to_string(&written.records).unwrap())));
}
