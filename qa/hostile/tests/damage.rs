//! What was written and is damaged is never read as something else: every bit, every cut.

use campaign::{CampaignError, Manifest, Row, Rows};
use contract::Record;
use hopper_sim::{JournalError, JournalReader};
use hostile::disk::Disk;
use recording::{Channel, RecordedMessage, Recording, recover};

/// `bytes` with each of its bits flipped in turn, and which.
fn flipped(bytes: &[u8]) -> impl Iterator<Item = (usize, Vec<u8>)> + '_ {
    (0..8 * bytes.len()).map(|bit| {
        let mut damaged = bytes.to_vec();
        damaged[bit / 8] ^= 1 << (bit % 8);
        (bit, damaged)
    })
}

/// Records and torn bytes of a journal.
fn records(bytes: &[u8]) -> Result<(Vec<Record>, u64), JournalError> {
    let disk = Disk::of(bytes);
    let history = JournalReader::on(&disk, "journal".into())?;
    let mut records = history.records();
    let whole = records.by_ref().collect::<Result<_, _>>()?;
    Ok((whole, records.torn_bytes()))
}

/// The rows of the fixtures' plan that `bytes` hold.
fn rows(bytes: &[u8]) -> Result<Vec<Row>, CampaignError> {
    let mut rows = Rows::new(hostile::campaign::manifest(), bytes);
    std::iter::from_fn(|| rows.next().transpose()).collect()
}

/// P-FLIPPED: Every flipped bit of a journal is detected.
#[test]
fn every_flipped_bit_of_a_journal_is_told() {
    let bytes = hostile::journal::seeds().remove(0);
    let (written, _) = records(&bytes).unwrap();
    assert!(written.len() > 5);
    for (bit, damaged) in flipped(&bytes) {
        // The last record alone is indistinguishable from one that death tore: it is cut, and its bytes are counted.
        if let Ok((read, torn_bytes)) = records(&damaged) {
            assert_eq!(read, written[..written.len() - 1], "bit {bit}");
            assert!(torn_bytes > 0, "bit {bit}");
        }
    }
}

/// P-FLIPPED-ROWS: Every flipped bit of a campaign's rows is detected, and every cut keeps the
/// whole rows before it.
#[test]
fn every_flipped_bit_of_rows_is_told_and_every_cut_keeps_the_whole_rows_before_it() {
    let bytes = hostile::campaign::rows().remove(0);
    let written = rows(&bytes).unwrap();
    assert_eq!(written.len(), 2);
    for (bit, damaged) in flipped(&bytes) {
        // Without its end the last line is a torn one.
        if let Ok(read) = rows(&damaged) {
            assert!(bit / 8 == bytes.len() - 1 && read == written[..1], "bit {bit}");
        }
    }
    for cut in 0..bytes.len() {
        let whole = bytes[..cut].iter().filter(|byte| **byte == b'\n').count();
        assert_eq!(rows(&bytes[..cut]).unwrap(), written[..whole], "cut at {cut}");
    }
}

/// P-FLIPPED-PLAN: Every flipped bit and every cut of a campaign's plan is detected.
#[test]
fn every_flipped_bit_of_a_plan_is_told() {
    let bytes = hostile::campaign::checkpoints().remove(0);
    let written = hostile::campaign::manifest();
    let parse = |bytes: &[u8]| Manifest::parse(std::str::from_utf8(bytes).ok()?).ok();
    assert_eq!(parse(&bytes).as_ref(), Some(written));
    for (bit, damaged) in flipped(&bytes) {
        // One white space for another behind the end changes nothing.
        let read = parse(&damaged);
        assert!(read.is_none() || bit / 8 == bytes.len() - 1, "bit {bit}");
    }
    for cut in 0..bytes.len() - 1 {
        assert!(parse(&bytes[..cut]).is_none(), "cut at {cut}");
    }
}

/// P-JOURNAL-LIMITS: A journal with more data behind its last record than a torn write leaves is
/// refused, not cut.
#[test]
fn a_journal_with_more_behind_its_last_record_than_a_torn_tail_is_refused() {
    let bytes = hostile::journal::seeds().remove(0);
    for (tail, refused) in [(1 << 20, false), ((1 << 20) + 1, true), (1 << 22, true)] {
        let mut long = bytes.clone();
        long.resize(bytes.len() + tail, 0);
        match records(&long) {
            Ok((_, torn_bytes)) => assert!(!refused && torn_bytes == tail as u64),
            Err(error @ JournalError::TornTooMuch { .. }) => {
                let text = error.to_string();
                assert!(
                    refused && text.contains("at most 1048576 bytes") && text.contains("truncate"),
                    "{text}"
                );
            }
            Err(error) => panic!("{error}"),
        }
    }
}

/// Messages of a recording: their topics and bytes.
fn entries(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let recording = Recording::read(bytes).unwrap();
    recording.entries().map(|entry| (entry.topic.clone(), entry.data.to_vec())).collect()
}

/// P-BAG-CUT: Every cut of a recording is read up to its last valid chunk, reported, and can be
/// recovered.
#[test]
fn every_cut_of_a_recording_is_read_up_to_its_last_valid_chunk() {
    let bytes = hostile::recording::seeds().remove(0);
    let written = entries(&bytes);
    let messages = hostile::recording::messages().len();
    assert!(written.len() > messages && Recording::read(&bytes).unwrap().is_whole());
    // Where a cut first keeps more: chunk by chunk, in order.
    let (mut kept, mut grew) = (0, 0);
    for cut in 8..bytes.len() {
        let recording = Recording::read(&bytes[..cut]).unwrap();
        assert!(!recording.is_whole() && recording.lost_bytes() <= cut as u64 - 8, "cut at {cut}");
        if recording.chunks() == grew {
            continue;
        }
        grew = recording.chunks();
        let read = entries(&bytes[..cut]);
        assert!(read.len() >= kept && read == written[..read.len()], "cut at {cut}");
        kept = read.len();
        assert_eq!(recording.lost_bytes(), 0, "a chunk that ends here is whole, cut at {cut}");
        let whole = recover(&recording).unwrap();
        assert!(Recording::read(&whole).unwrap().is_whole());
        assert_eq!(entries(&whole), read, "cut at {cut}");
    }
    assert!(kept == written.len() && grew > 3, "{grew} chunks");
    for cut in 0..8 {
        assert!(Recording::read(&bytes[..cut]).is_err());
    }
}

/// P-BAG-FLIPPED: A flipped bit of a recording, sampled at one bit in 56, is detected or harms no
/// message.
#[test]
fn a_flipped_bit_of_a_recording_is_told_or_harms_no_message_as_sampled() {
    let bytes = hostile::recording::seeds().remove(0);
    let written = entries(&bytes);
    // A bit of every seventh byte, each of the eight in turn: the schemas stand twice and are large.
    for byte in (0..bytes.len()).step_by(7) {
        let bit = 8 * byte + byte / 7 % 8;
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let Ok(recording) = Recording::read(&damaged) else { continue };
        let read = entries(&damaged);
        match recording.is_whole() {
            true => assert!(read == written, "bit {bit}"),
            false => assert!(read == written[..read.len()], "bit {bit}"),
        }
    }
}

/// P-BAG-MESSAGES: Every kind of message comes back unchanged from a recording.
#[test]
fn every_message_of_a_recording_comes_back_as_it_was() {
    let bytes = hostile::recording::seeds().remove(0);
    let recording = Recording::read(&bytes).unwrap();
    let read: Vec<RecordedMessage> = recording.messages().map(|message| message.unwrap().1).collect();
    let written = hostile::recording::messages();
    let mut read = read.into_iter();
    for message in &written {
        // What the recorder adds stands between them.
        assert!(read.any(|got| got == *message), "{message:?}");
    }
    let topics: std::collections::BTreeSet<_> = written.iter().map(RecordedMessage::topic).collect();
    assert_eq!(
        topics.len(),
        Channel::ALL.iter().filter(|topic| !topic.is_view()).count(),
        "every kind is there"
    );
}

/// P-BAG-FLUSH: What was recorded half a second ago is in a complete chunk, so a kill loses no more
/// than that.
#[test]
fn what_was_recorded_half_a_second_ago_survives_a_kill() {
    use contract::MonotonicNs;
    use recording::recorder::{CHUNK_NS, Recorder};
    let mut now = MonotonicNs(7);
    let mut recorder = Recorder::new(&recording::Context::new(), now).unwrap();
    let mut bytes = recorder.bytes();
    let mut recorded: Vec<(MonotonicNs, RecordedMessage)> = Vec::new();
    for message in hostile::recording::messages() {
        recorder.on(message.clone(), now).unwrap();
        recorded.push((now, message));
        now = now.plus_ns(CHUNK_NS / 4);
        recorder.tick(now).unwrap();
        bytes.extend(recorder.bytes());
        let kept: Vec<RecordedMessage> = {
            let recording = Recording::read(&bytes).unwrap();
            recording.messages().map(|message| message.unwrap().1).collect()
        };
        let old = recorded.iter().filter(|(then, _)| now.since_ns(*then) >= CHUNK_NS);
        for (then, message) in old {
            assert!(kept.contains(message), "{message:?} of {then:?} is not there at {now:?}");
        }
    }
}
