//! The header of a journal: what stands in it for each kind of mission, and what of another build is refused.

use std::fs;
use std::path::Path;

use contract::{Brief, Limits, RunId};
use hopper_sim::journal::{FILE_NAME, FORMAT};
use hopper_sim::{Journal, JournalError, JournalHeader, JournalReader, verify};
use scenario::ResolvedScenario;
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::fixture::{frame, header_payloads};

fn world(scenario: &str) -> ResolvedScenario {
    scenario::load(scenario).unwrap().resolve().unwrap()
}

fn header(scenario: &str) -> JournalHeader {
    JournalHeader::new(&world(scenario), 7).with_run(RunId(5))
}

/// A journal without records.
fn begun(header: &JournalHeader) -> (TempDir, Vec<u8>) {
    let dir = tempdir().unwrap();
    drop(Journal::create(dir.path(), header, false).unwrap());
    let bytes = fs::read(dir.path().join(FILE_NAME)).unwrap();
    (dir, bytes)
}

/// The text of the header that `bytes` begin with.
fn text(bytes: &[u8]) -> Value {
    let [_, text] = header_payloads(bytes);
    serde_json::from_slice(&bytes[text]).unwrap()
}

/// The journal in `dir` with this format, build and text before its records, of which it has none.
fn rewrite(dir: &Path, format: u32, version: &str, text: &Value) {
    let [version, text] = [frame(version.as_bytes()), frame(text.to_string().as_bytes())];
    let bytes = [&b"HOPJRNL\n"[..], &format.to_le_bytes(), &version, &text].concat();
    fs::write(dir.join(FILE_NAME), bytes).unwrap();
}

/// Why the journal in `dir` is refused by all who open one, which leave it as it is.
fn refusal(dir: &Path) -> JournalError {
    let before = fs::read(dir.join(FILE_NAME)).unwrap();
    let (expected, ground) = (header("hard"), world("hard").terrain);
    let error = JournalReader::open(dir).unwrap_err();
    for other in [
        verify(dir).unwrap_err(),
        Journal::open(dir, false).unwrap_err(),
        Journal::resume(dir, &expected, &ground, false).unwrap_err(),
        Journal::resume_run(dir, &expected, &ground, false).unwrap_err(),
    ] {
        assert_eq!(other.to_string(), error.to_string());
    }
    assert_eq!((error.exit(), error.to_string().lines().count()), (process::Exit::Usage, 1), "{error}");
    assert_eq!(fs::read(dir.join(FILE_NAME)).unwrap(), before);
    error
}

/// P-JOURNAL-HEADER: The header of a journal names its format, the build that wrote it and each of
/// its fields; that of each kind of mission is read back as it was written.
#[test]
fn the_header_of_each_kind_of_mission_names_itself_and_is_read_back_whole() {
    let kinds = ["hard", "treasures", "patrol", "coverage", "rover-helicopter", "hopper-scout", "expedition"];
    let mut headers = kinds.map(|scenario| (scenario, header(scenario))).to_vec();
    let mut stages = header("rover-helicopter");
    stages.brief.sampling.as_mut().unwrap().stages = 3;
    headers.push(("rover-helicopter", stages));
    for (scenario, header) in headers {
        let (dir, bytes) = begun(&header);
        let [version, _] = header_payloads(&bytes);
        assert_eq!((&bytes[..8], &bytes[8..12]), (&b"HOPJRNL\n"[..], &FORMAT.to_le_bytes()[..]));
        assert_eq!(bytes[version], *env!("CARGO_PKG_VERSION").as_bytes());
        let text = text(&bytes);
        assert_eq!((&text["seed"], &text["brief"]["scenario"]), (&json!(7), &json!(scenario)));
        assert_eq!(text["resolved"], json!(header.resolved));
        assert_eq!(JournalReader::open(dir.path()).unwrap().header(), &header, "{scenario}");
        let again = Journal::resume_run(dir.path(), &header, &world(scenario).terrain, false).unwrap();
        assert_eq!((again.header(), again.is_empty(), again.len()), (&header, true, 0), "{scenario}");
    }
}

/// P-OTHER-FORMAT. The first bytes decide, whatever follows them.
#[test]
fn a_journal_of_an_older_format_is_refused_with_the_build_that_reads_it() {
    let (dir, bytes) = begun(&header("hard"));
    for format in 2_u32..=10 {
        let older = [&b"HOPPERJ\n"[..], &format.to_le_bytes(), &bytes[12..]].concat();
        fs::write(dir.path().join(FILE_NAME), older).unwrap();
        let told = format!(
            "{} is of an older format, which this build does not read: use a build of 25 November 2026 or before (format {format})",
            dir.path().join(FILE_NAME).display()
        );
        assert_eq!(refusal(dir.path()).to_string(), told);
    }
}

/// P-OTHER-FORMAT.
#[test]
fn a_journal_of_a_newer_format_is_refused_with_the_build_that_wrote_it() {
    let (dir, bytes) = begun(&header("hard"));
    for format in [FORMAT + 1, 3, u32::MAX] {
        rewrite(dir.path(), format, "7.8.9", &text(&bytes));
        let told = format!(
            "{} is of a newer format than this build reads: it was written by version 7.8.9 (format {format})",
            dir.path().join(FILE_NAME).display()
        );
        assert_eq!(refusal(dir.path()).to_string(), told);
    }
    rewrite(dir.path(), 0, "7.8.9", &text(&bytes));
    assert!(matches!(refusal(dir.path()), JournalError::BadHeader { .. }));
}

/// P-HEADER-FIELDS: An unknown field of a journal's header is refused by name; a missing one has
/// its default, or is refused by name.
#[test]
fn a_field_of_the_header_that_is_not_known_is_refused_by_name() {
    let (dir, bytes) = begun(&header("expedition"));
    type Change = fn(&mut Value);
    let cases: [(&str, Change); 4] = [
        ("weather", |text| text["weather"] = json!({ "wind": 1.0 })),
        ("brief.guard.patience", |text| text["brief"]["guard"]["patience"] = json!(null)),
        ("brief.robots.0.start.tilt", |text| text["brief"]["robots"][0]["start"]["tilt"] = json!([])),
        ("brief.robots.1.wings", |text| text["brief"]["robots"][1]["wings"] = json!(2)),
    ];
    for (field, change) in cases {
        let mut text = text(&bytes);
        change(&mut text);
        rewrite(dir.path(), FORMAT, "7.8.9", &text);
        let told = format!(
            "{} has the field {field} in its header, which this build does not know: it was written by version 7.8.9",
            dir.path().join(FILE_NAME).display()
        );
        assert_eq!(refusal(dir.path()).to_string(), told);
    }
    // Of a text that somebody else wrote, an error quotes a part.
    let mut text = text(&bytes);
    text[&"long\n".repeat(10_000)] = json!(0);
    rewrite(dir.path(), FORMAT, "7.8.9", &text);
    assert!(refusal(dir.path()).to_string().len() < 600);
}

/// P-HEADER-FIELDS.
#[test]
fn a_field_that_the_header_leaves_out_has_its_default_or_is_refused_by_name() {
    let header = header("rover-helicopter");
    let (dir, bytes) = begun(&header);
    let without = |fields: &[&str]| {
        let mut text = text(&bytes);
        let (last, path) = fields.split_last().unwrap();
        let object = path.iter().fold(&mut text, |value, field| &mut value[*field]);
        object.as_object_mut().unwrap().remove(*last);
        rewrite(dir.path(), FORMAT, "0.0.1", &text);
    };
    for optional in [&["brief", "reading", "leaving"][..], &["brief", "reading", "distance_scale_cells"]] {
        without(optional);
        assert_eq!(JournalReader::open(dir.path()).unwrap().header(), &header, "{optional:?}");
    }
    for needed in [&["brief"][..], &["seed"], &["resolved"], &["brief", "limits", "steps_max"]] {
        without(needed);
        let (error, field) = (refusal(dir.path()), needed.last().unwrap());
        let told = format!("missing field `{field}`");
        assert!(
            matches!(&error, JournalError::BadHeader { reason, .. } if reason.contains(&told)),
            "{error}"
        );
    }
}

#[test]
fn a_journal_is_resumed_with_another_budget_and_not_as_another_run() {
    let (dir, written) = (tempdir().unwrap(), header("hard"));
    assert!(!Journal::exists(dir.path()));
    drop(Journal::create(dir.path(), &written, false).unwrap());
    assert!(Journal::exists(dir.path()));
    let limits = Limits { decision_budget_ns: 1, ..written.brief.limits };
    let hurried = JournalHeader { brief: Brief { limits, ..written.brief.clone() }, ..written.clone() };
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
