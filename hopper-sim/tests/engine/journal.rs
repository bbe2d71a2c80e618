//! What the journal's file survives, and what it refuses.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use contract::limits::PAST_PAGE_RECORDS;
use contract::{Branch, Cell, Collected, Decision, Flight, Outcome, Pose, Profile, Record, Status};
use hopper_sim::journal::FILE_NAME;
use hopper_sim::{Journal, JournalError, JournalHeader, JournalReader};
use proptest::prelude::*;
use tempfile::{TempDir, tempdir};

use crate::fixture::{header, header_payloads, mission, undisturbed};

/// A closed journal of the undisturbed mission in its own directory, with where each frame ends.
pub struct Written {
    pub dir: TempDir,
    pub records: Vec<Record>,
    pub ends: Vec<u64>,
}

impl Written {
    pub fn new() -> Self {
        Self::of(undisturbed())
    }

    pub fn of(records: Vec<Record>) -> Self {
        Self::with(&header(&mission()), records)
    }

    fn with(header: &JournalHeader, records: Vec<Record>) -> Self {
        let dir = tempdir().unwrap();
        let mut journal = Journal::create(dir.path(), header, false).unwrap();
        let bytes = || fs::metadata(dir.path().join(FILE_NAME)).unwrap().len();
        let mut ends = vec![bytes()];
        for record in &records {
            journal.append(record, None).unwrap();
            ends.push(bytes());
        }
        Self { dir, records, ends }
    }

    pub fn path(&self) -> &Path {
        self.dir.path()
    }

    pub fn bytes(&self) -> Vec<u8> {
        fs::read(self.path().join(FILE_NAME)).unwrap()
    }

    pub fn overwrite(&self, bytes: &[u8]) {
        fs::write(self.path().join(FILE_NAME), bytes).unwrap();
    }

    /// Bytes of the frame of `decision`.
    pub fn frame(&self, decision: usize) -> std::ops::Range<usize> {
        self.ends[decision] as usize..self.ends[decision + 1] as usize
    }
}

/// What can be read of the journal in `dir` without changing it: records and torn bytes.
fn read(dir: &Path) -> Result<(Vec<Record>, u64), JournalError> {
    let history = JournalReader::open(dir)?;
    let mut records = history.records();
    let whole = records.by_ref().collect::<Result<_, _>>()?;
    Ok((whole, records.torn_bytes()))
}

#[test]
fn what_was_appended_is_read_back_by_page_by_record_and_after_reopening() {
    // Longer than a page: the same mission's records, chained on and on.
    let mut records = undisturbed();
    while records.len() < 2 * PAST_PAGE_RECORDS + 3 {
        let last = *records.last().unwrap();
        let mut next = Record { decision: last.decision.next(), previous: last.digest, ..last };
        next.digest = next.previous.chain(&next);
        records.push(next);
    }
    let written = Written::of(records.clone());
    let journal = Journal::open(written.path(), false).unwrap();
    assert_eq!(
        (journal.len(), journal.last(), journal.torn_bytes()),
        (records.len() as u64, records.last(), 0)
    );
    assert_eq!(journal.records().collect::<Result<Vec<_>, _>>().unwrap(), records);
    for from in [0, 1, PAST_PAGE_RECORDS, records.len() - 1, records.len(), records.len() + 5] {
        let page = journal.page(Decision(from as u64)).unwrap();
        let until = (from + PAST_PAGE_RECORDS).min(records.len()).max(from);
        assert_eq!(page.records, records.get(from..until).unwrap_or_default(), "from {from}");
        assert_eq!((page.run, page.from), (mission().brief.run, Decision(from as u64)));
    }
    assert_eq!(journal.page(Decision(u64::MAX)).unwrap().records, []);
    assert_eq!(journal.header(), &header(&mission()));
}

/// P-INDEX: A page of a journal can begin at any record, however long the journal is.
///
/// Beyond 16,384 records only some offsets are kept; records between them are found by reading.
#[test]
fn any_page_of_a_long_journal_begins_where_it_is_asked_for() {
    let mut records = undisturbed();
    while records.len() < 40_003 {
        let last = *records.last().unwrap();
        let mut next = Record { decision: last.decision.next(), previous: last.digest, ..last };
        next.digest = next.previous.chain(&next);
        records.push(next);
    }
    let dir = tempdir().unwrap();
    let mut journal = Journal::create(dir.path(), &header(&mission()), false).unwrap();
    assert!(journal.is_empty());
    records.iter().for_each(|record| journal.append(record, None).unwrap());
    assert!(!journal.is_empty());
    for from in [16_383, 16_385, 32_769, 39_998, 39_999, 40_001, 40_002, 40_003] {
        let page = journal.page(Decision(from as u64)).unwrap();
        let until = (from + PAST_PAGE_RECORDS).min(records.len());
        assert_eq!(page.records, records[from..until], "from {from}");
    }
}

/// P-TORN.
#[test]
fn cut_at_every_byte_it_is_read_up_to_its_last_whole_record() {
    let written = Written::new();
    let file = fs::OpenOptions::new().write(true).open(written.path().join(FILE_NAME)).unwrap();
    for cut in (0..file.metadata().unwrap().len()).rev() {
        file.set_len(cut).unwrap();
        let whole = written.ends.iter().rposition(|&end| end <= cut);
        match (whole, read(written.path())) {
            (None, Err(JournalError::BadHeader { .. })) => {}
            (Some(whole), Ok((records, torn_bytes))) => {
                assert_eq!(records, written.records[..whole], "cut at byte {cut}");
                assert_eq!(torn_bytes, cut - written.ends[whole]);
            }
            (whole, got) => panic!("cut at byte {cut}: needs {whole:?} records, got {got:?}"),
        }
    }
}

#[test]
fn opening_cuts_a_torn_tail_says_how_much_and_goes_on_from_there() {
    let written = Written::new();
    let bytes = written.bytes();
    let torn_at = written.ends[6];
    for torn_bytes in [1, 7, 8, 9, 100] {
        written.overwrite(&bytes[..(torn_at + torn_bytes) as usize]);
        let mut journal = Journal::open(written.path(), torn_bytes == 8).unwrap();
        assert_eq!((journal.torn_bytes(), journal.len()), (torn_bytes, 6));
        assert_eq!(written.bytes(), bytes[..torn_at as usize]);
        for record in &written.records[6..] {
            journal.append(record, None).unwrap();
        }
        assert_eq!(written.bytes(), bytes);
    }
}

#[test]
fn a_tail_of_zeros_as_power_loss_leaves_it_is_torn_too() {
    let written = Written::new();
    let mut bytes = written.bytes();
    bytes.extend([0; 100_000]);
    written.overwrite(&bytes);
    let journal = Journal::open(written.path(), false).unwrap();
    assert_eq!((journal.torn_bytes(), journal.len()), (100_000, written.records.len() as u64));
}

#[test]
fn a_broken_frame_before_whole_ones_is_refused_with_its_offset_and_nothing_is_cut() {
    let written = Written::new();
    for decision in [0, 3, written.records.len() - 2] {
        let frame = written.frame(decision);
        // In its length, its checksum, its payload.
        for broken in [frame.start, frame.start + 3, frame.start + 5, frame.start + 8, frame.end - 1] {
            let mut bytes = written.bytes();
            let intact = bytes.clone();
            bytes[broken] ^= 0x10;
            written.overwrite(&bytes);
            let error = Journal::open(written.path(), false).unwrap_err();
            let JournalError::Corrupt { offset, whole_at, .. } = error else { panic!("{error}") };
            assert_eq!((offset, whole_at), (frame.start as u64, frame.end as u64));
            assert_eq!(written.bytes(), bytes);
            written.overwrite(&intact);
        }
    }
}

proptest! {
    #[test]
    fn no_flipped_bit_ever_reads_as_another_record(at in any::<prop::sample::Index>(), bit in 0..8_u8) {
        thread_local! {
            static WRITTEN: (Written, Vec<u8>) = { let written = Written::new(); let bytes = written.bytes(); (written, bytes) };
        }
        WRITTEN.with(|(written, intact)| {
            let at = at.index(intact.len());
            let mut bytes = intact.clone();
            bytes[at] ^= 1 << bit;
            written.overwrite(&bytes);
            let last = written.records.len() - 1;
            match read(written.path()) {
                Err(_) => prop_assert!(at < written.frame(last).start, "the last frame alone is cut as torn"),
                Ok((records, torn_bytes)) => {
                    prop_assert!(written.frame(last).contains(&at), "byte {} changed unseen", at);
                    prop_assert_eq!(&records[..], &written.records[..last]);
                    prop_assert_eq!(torn_bytes, written.frame(last).len() as u64);
                }
            }
            Ok(())
        })?;
    }

    #[test]
    fn no_garbage_is_taken_for_a_journal_or_ends_it_in_panic(garbage in prop::collection::vec(any::<u8>(), 0..300), keep in any::<prop::sample::Index>()) {
        let written = Written::new();
        let mut bytes = written.bytes();
        bytes.truncate(keep.index(bytes.len()));
        bytes.extend(&garbage);
        written.overwrite(&bytes);
        if let Ok((records, _)) = read(written.path()) {
            prop_assert_eq!(&records[..], &written.records[..records.len()]);
        }
    }
}

#[test]
fn records_out_of_order_or_off_the_chain_are_not_appended() {
    let written = Written::of(undisturbed()[..3].to_vec());
    let all = undisturbed();
    let mut journal = Journal::open(written.path(), false).unwrap();
    for wrong in [all[2], all[4]] {
        assert!(matches!(
            journal.append(&wrong, None),
            Err(JournalError::OutOfOrder { need: Decision(3), .. })
        ));
    }
    let forged = Record { previous: all[0].digest, ..all[3] };
    assert!(matches!(
        journal.append(&forged, None),
        Err(JournalError::BrokenChain { decision: Decision(3), .. })
    ));
    journal.append(&all[3], None).unwrap();
}

#[test]
fn frames_out_of_order_are_refused_on_opening() {
    let written = Written::new();
    let bytes = written.bytes();
    let doubled = [&bytes[..written.frame(4).end], &bytes[written.frame(4).start..]].concat();
    written.overwrite(&doubled);
    let error = Journal::open(written.path(), false).unwrap_err();
    assert!(matches!(error, JournalError::OutOfOrder { need: Decision(5), got: Decision(4) }), "{error}");
}

#[test]
fn a_second_writer_is_refused_and_told_who_holds_the_journal() {
    let written = Written::new();
    let held = Journal::open(written.path(), false).unwrap();
    let this_header = header(&mission());
    for second in [
        Journal::open(written.path(), false),
        Journal::resume(written.path(), &this_header, &mission().terrain, false),
        Journal::create(written.path(), &this_header, false),
    ] {
        let error = second.unwrap_err();
        assert!(matches!(&error, JournalError::Locked { pid: Some(pid), .. } if *pid == std::process::id()));
        assert!(error.to_string().contains(&format!("held by process {}", std::process::id())), "{error}");
    }
    read(written.path()).expect("readers need no lock");
    drop(held);
    Journal::open(written.path(), false).unwrap();
}

#[test]
fn a_new_run_does_not_overwrite_a_journal_and_a_missing_one_is_not_made_by_opening() {
    let written = Written::new();
    let bytes = written.bytes();
    let error = Journal::create(written.path(), &header(&mission()), false).unwrap_err();
    assert!(matches!(error, JournalError::Exists { .. }), "{error}");
    assert_eq!(written.bytes(), bytes);
    let nowhere = written.path().join("nowhere");
    assert!(!Journal::exists(&nowhere));
    assert!(matches!(Journal::open(&nowhere, false), Err(JournalError::Missing { .. })));
    assert!(matches!(read(&nowhere), Err(JournalError::Missing { .. })));
    assert!(!nowhere.exists());
}

#[test]
fn a_death_while_the_header_was_written_leaves_room_for_the_next_attempt() {
    let dir = tempdir().unwrap();
    fs::write(dir.path().join(format!("{FILE_NAME}.new")), b"half a header and more of it than needed")
        .unwrap();
    let journal = Journal::create(dir.path(), &header(&mission()), true).unwrap();
    drop(journal);
    assert_eq!(read(dir.path()).unwrap(), (vec![], 0));
}

#[test]
fn another_missions_journal_is_refused_naming_field_need_and_got() {
    let written = Written::new();
    let mut torn = written.bytes();
    torn.extend(b"torn");
    written.overwrite(&torn);
    let base = header(&mission());
    let other = |change: fn(&mut JournalHeader)| {
        let mut header = base.clone();
        change(&mut header);
        header
    };
    for (field, expected) in [
        ("ground", other(|header| header.brief.scenario_hash[31] ^= 1)),
        ("scenario", other(|header| header.brief.scenario = "other".parse().unwrap())),
        ("seed", other(|header| header.seed += 1)),
        ("profile", other(|header| header.brief.profile = Profile::Paper2023)),
        ("brief.limits.steps_max", other(|header| header.brief.limits.steps_max += 1)),
    ] {
        let error = Journal::resume(written.path(), &expected, &mission().terrain, false).unwrap_err();
        let JournalError::Mismatch { field: got, need, got: found } = &error else { panic!("{error}") };
        assert_eq!(*got, field);
        assert!(need != found && error.to_string().contains(need) && error.to_string().contains(found));
        assert_eq!(written.bytes(), torn, "and its torn tail is left alone");
    }
    let another = base.clone().with_run(contract::RunId(1));
    let journal = Journal::resume(written.path(), &another, &mission().terrain, false).unwrap();
    assert_eq!((journal.header().run(), journal.torn_bytes()), (base.run(), 4));
}

#[test]
fn another_kind_of_file_is_refused() {
    let written = Written::new();
    let bytes = written.bytes();
    let mut damaged = bytes.clone();
    damaged[40] ^= 1;
    let mut long = bytes.clone();
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    for wrong in [&b""[..], b"II*\0", b"HOPPERJ", &[0; 4096], &bytes[..20], &damaged, &long] {
        written.overwrite(wrong);
        let error = Journal::open(written.path(), false).unwrap_err();
        assert!(matches!(error, JournalError::BadHeader { .. }), "{error}");
        assert_eq!(written.bytes(), wrong);
    }
}

#[test]
fn journal_and_directory_are_for_the_owner_only() {
    let dir = tempdir().unwrap();
    let journal = dir.path().join("missions").join("first");
    drop(Journal::create(&journal, &header(&mission()), false).unwrap());
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&journal), 0o700);
    assert_eq!(mode(&journal.join(FILE_NAME)), 0o600);
    assert_eq!(mode(&journal.join("lock")), 0o600);
}

/// P-FULL: On a full disk only whole records are left, and the same record is written once there is
/// space.
#[test]
fn a_full_disk_leaves_whole_records_only_and_the_very_same_one_fits_later() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    const CHILD: &str = "HOPPER_TEST_FULL_DISK";
    let this = "journal::a_full_disk_leaves_whole_records_only_and_the_very_same_one_fits_later";
    if std::env::var_os(CHILD).is_none() {
        // A limit on file sizes is the process's, so it is set in a process of its own.
        let ignoring = r#"trap "" XFSZ; exec "$0" "$@""#;
        let output = Command::new("sh")
            .args(["-c", ignoring])
            .arg(std::env::current_exe().unwrap())
            .args(["--exact", this])
            .env(CHILD, "1")
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && text.contains("1 passed"), "{text}");
        return;
    }
    let all = undisturbed();
    let written = Written::of(all[..4].to_vec());
    let intact = written.bytes();
    let limits = getrlimit(Resource::Fsize);
    for (sync, rooms) in [(false, &[0, 1, 8, 200][..]), (true, &[100])] {
        let mut journal = Journal::open(written.path(), sync).unwrap();
        for room in rooms {
            let full = intact.len() as u64 + room;
            setrlimit(Resource::Fsize, Rlimit { current: Some(full), ..limits }).unwrap();
            let error = journal.append(&all[4], None).unwrap_err();
            setrlimit(Resource::Fsize, limits).unwrap();
            assert!(matches!(&error, JournalError::Io { action: "append to", .. }), "{error}");
            assert_eq!(written.bytes(), intact, "with room for {room} bytes");
            assert_eq!((journal.len(), journal.last()), (4, all[3..4].last()));
        }
        journal.append(&all[4], None).unwrap();
        drop(journal);
        assert_eq!(read(written.path()).unwrap(), (all[..5].to_vec(), 0));
        written.overwrite(&intact);
    }
}

#[test]
fn the_bytes_of_format_1_are_golden() {
    let flight = Flight {
        launch_speed_mps: 1.9,
        launch_angle_rad: 0.8,
        range_m: 1.0,
        rise_m: -0.5,
        apex_height_m: 0.25,
        flight_time_s: 0.7,
        flights: 1,
    };
    // Numbers of the contract alone, so that only a changed layout changes the bytes.
    let mut records = undisturbed()[..2].to_vec();
    let mut digest = mission().genesis();
    for record in &mut records {
        record.outcome =
            Outcome { branch: Branch::Left, from: Cell::new(1, 2), to: Cell::new(-1, 3), flight };
        record.collected = Collected(0b101);
        record.pose = Pose { cell: record.outcome.to, height_m: -0.125 };
        (record.steps, record.status) = (2 * record.decision.next().0, Status::Underway);
        record.previous = digest;
        digest = digest.chain(record);
        record.digest = digest;
    }
    let header = JournalHeader { resolved: "[truth]\nkind = \"ramp\"\n".into(), ..header(&mission()) };
    let bytes = Written::with(&header, records).bytes();
    let [_, text] = header_payloads(&bytes);
    assert_eq!(std::str::from_utf8(&bytes[text.clone()]), Ok(include_str!("golden.json").trim_end()));
    let lines = bytes[text.end..].chunks(32);
    let lines = lines.map(|line| line.iter().map(|byte| format!("{byte:02x}")).collect::<String>() + "\n");
    assert_eq!(lines.collect::<String>(), include_str!("golden.hex"), "a changed record takes a new FORMAT");
}
