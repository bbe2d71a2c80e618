//! Recordings that other programs have put into another order, put together, extended or damaged: what `hopper bag` makes
//! of them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use contract::{Brief, MonotonicNs, RunId, State};
use hostile::fixtures;
use recording::{Context, RecordedMessage, Recorder, Recording, last_run, recover};
use scenario::Scenario;
use serde_json::Value;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const METADATA: u8 = 0x0c;
const DATA_END: u8 = 0x0f;

/// Opcode and body of a record.
type Record = (u8, Vec<u8>);

fn records(mut bytes: &[u8]) -> Vec<Record> {
    let mut records = Vec::new();
    while bytes.len() >= 9 {
        let length = u64::from_le_bytes(bytes[1..9].try_into().unwrap()) as usize;
        records.push((bytes[0], bytes[9..9 + length].to_vec()));
        bytes = &bytes[9 + length..];
    }
    records
}

fn framed((kind, body): &Record) -> Vec<u8> {
    [&[*kind][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

/// Metadata, definitions (schemas and channels) and messages of a recording of Hopper's.
struct Contents {
    metadata: Vec<Record>,
    definitions: Vec<Record>,
    messages: Vec<Record>,
}

impl Contents {
    fn of(bytes: &[u8]) -> Self {
        const CHUNK_HEADER_BYTES: usize = 24 + 4 + 4 + 8;
        let all = records(&bytes[MAGIC.len()..bytes.len() - MAGIC.len()]);
        let metadata = all.iter().filter(|(kind, _)| *kind == METADATA).cloned().collect();
        let chunks = all.iter().filter(|(kind, _)| *kind == CHUNK);
        let data: Vec<Record> = chunks.flat_map(|(_, body)| records(&body[CHUNK_HEADER_BYTES..])).collect();
        let (messages, definitions) = data.into_iter().partition(|(kind, _)| *kind == MESSAGE);
        Self { metadata, definitions, messages }
    }

    /// Number of the channel of `topic`.
    fn channel(&self, topic: &str) -> [u8; 2] {
        let topic = [&(topic.len() as u32).to_le_bytes()[..], topic.as_bytes()].concat();
        let is_of_topic = |(kind, body): &&Record| *kind == CHANNEL && body[4..].starts_with(&topic);
        let (_, body) = self.definitions.iter().find(is_of_topic).unwrap();
        [body[0], body[1]]
    }
}

/// A chunk without compression and checksum.
fn chunk(records: &[Record]) -> Record {
    let stored: Vec<u8> = records.iter().flat_map(framed).collect();
    let size = (stored.len() as u64).to_le_bytes();
    (CHUNK, [&[0; 16][..], &size, &[0; 4], &[0; 4], &size, &stored].concat())
}

/// A file without checksums, of records in its data and in its summary.
fn file(data: &[Record], summary: &[Record]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(framed(&(HEADER, vec![0; 8])));
    data.iter().for_each(|record| bytes.extend(framed(record)));
    bytes.extend(framed(&(DATA_END, vec![0; 4])));
    let start = if summary.is_empty() { 0 } else { bytes.len() as u64 };
    summary.iter().for_each(|record| bytes.extend(framed(record)));
    bytes.extend(framed(&(FOOTER, [&start.to_le_bytes()[..], &[0; 12]].concat())));
    bytes.extend(MAGIC);
    bytes
}

/// Topic, log time and data of every message, in the order of the reader.
fn messages(bytes: &[u8]) -> Vec<(String, MonotonicNs, Vec<u8>)> {
    let recording = Recording::read(bytes).unwrap();
    recording.entries().map(|entry| (entry.topic, entry.logged, entry.data.to_vec())).collect()
}

/// The messages of a recording in one order: those with one log time stand in that of their causes,
/// or of the file.
fn sorted(bytes: &[u8]) -> Vec<(String, MonotonicNs, Vec<u8>)> {
    let mut messages = messages(bytes);
    messages.sort();
    messages
}

fn seed() -> Vec<u8> {
    hostile::recording::seeds().remove(0)
}

/// A folder in which `hopper bag` is called.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn bag(&self, words: &[&str]) -> Output {
        let mut command = Command::new(Path::new(env!("CARGO_BIN_EXE_hopper-recordings")));
        command.arg("bag").args(words).current_dir(&self.0).output().unwrap()
    }

    /// `hopper bag info FILE`, and its exit code.
    fn info(&self, file: &str) -> (Value, Option<i32>) {
        let output = self.bag(&["info", file, "--format", "json"]);
        (serde_json::from_slice(&output.stdout).unwrap(), output.status.code())
    }

    /// The error of a recovery that is refused.
    fn refusal(&self, file: &str, out: &str) -> String {
        let output = self.bag(&["recover", file, out]);
        assert_eq!(output.status.code(), Some(2), "{file} {out}: {}", stderr(&output));
        stderr(&output)
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// P-BAG-REORDERED: Messages are read and recovered wherever the file defines their channels, in a
/// later chunk or only in the summary. Messages without a channel are counted, such a file is
/// reported as incomplete, and no empty file is written.
#[test]
fn messages_are_read_wherever_their_channels_stand() {
    let bytes = seed();
    let Contents { metadata, definitions, messages: sent } = Contents::of(&bytes);
    let backwards: Vec<Record> = definitions.iter().rev().cloned().collect();
    let mut chunks: Vec<Record> = [definitions.as_slice(), &sent].concat().chunks(10).map(chunk).collect();
    chunks.reverse();
    let data = |data: &[Record]| [&metadata, data].concat();
    for (name, reordered) in [
        ("chunks backwards", file(&data(&chunks), &[])),
        ("chunks backwards, with a summary", file(&data(&chunks), &definitions)),
        ("channels after messages", file(&data(&[chunk(&[sent.clone(), backwards.clone()].concat())]), &[])),
        ("channels in another chunk", file(&data(&[chunk(&sent), chunk(&definitions)]), &[])),
        ("channels in the summary", file(&data(&[chunk(&sent)]), &backwards)),
        ("channels in the summary, no chunk", file(&data(&sent), &definitions)),
    ] {
        let recording = Recording::read(&reordered).unwrap();
        assert!(recording.is_whole(), "{name}: {:?}", recording.fault);
        assert!(sorted(&reordered) == sorted(&bytes), "{name}");
        let (got, need) =
            (last_run(&recording).unwrap(), last_run(&Recording::read(&bytes).unwrap()).unwrap());
        assert_eq!((got.state, got.records), (need.state, need.records), "{name}");
        let whole = recover(&recording).unwrap();
        assert!(Recording::read(&whole).unwrap().is_whole(), "{name}");
        assert!(sorted(&whole) == sorted(&bytes), "{name}");
    }
    // A file that is damaged after its messages has its channels from the summary.
    let damaged = [chunk(&sent), (0, Vec::new())];
    let damaged = file(&damaged, &definitions);
    assert!(Recording::read(&damaged).unwrap().fault.unwrap().contains("kind 0x00"));
    assert!(sorted(&damaged) == sorted(&bytes));
}

/// P-BAG-REORDERED. Messages without a channel are counted, and no empty file is written.
#[test]
fn messages_without_a_channel_are_a_fault_and_no_empty_file_is_written() {
    let folder = Folder::new();
    let contents = Contents::of(&seed());
    let count = contents.messages.len() as u64;
    folder.write("none.mcap", &file(&[chunk(&contents.messages)], &[]));
    let (told, code) = folder.info("none.mcap");
    assert_eq!((code, &told["whole"], &told["without_channel"]), (Some(1), &false.into(), &count.into()));
    let need = format!("{count} messages have a channel that is not in the file");
    assert_eq!(told["fault"], need);
    let refusal = folder.refusal("none.mcap", "out.mcap");
    assert!(refusal.contains("no message can be recovered") && refusal.contains(&need), "{refusal}");
    assert!(!folder.path("out.mcap").exists());

    let state = contents.channel("hop/state");
    let of_state = |(_, body): &&Record| body[..2] == state;
    let states = contents.messages.iter().filter(of_state).count();
    let without: Vec<Record> = contents
        .definitions
        .iter()
        .filter(|(kind, body)| *kind == SCHEMA || body[..2] != state)
        .cloned()
        .collect();
    folder.write("some.mcap", &file(&[chunk(&without), chunk(&contents.messages)], &[]));
    let output = folder.bag(&["recover", "some.mcap", "out.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let lost = format!("{states} messages without a channel left out");
    assert!(stderr(&output).contains(&lost), "{}", stderr(&output));
    let whole = folder.read("out.mcap");
    let recovered = Recording::read(&whole).unwrap();
    assert_eq!(recovered.entries().count() as u64, count - states as u64);
    assert_eq!(recovered.metadata["recovered"]["without_channel"], states.to_string());
}

/// A short recording of a mission of `scenario`, recorded from `started_ns` on.
fn mission(scenario: &str, run: u128, seed: &str, started_ns: u64) -> Vec<u8> {
    let entry = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    let hopper =
        [entry("seed", seed), entry("version", "0.1.0"), entry("started_ns", &started_ns.to_string())];
    let context = Context::from([
        ("hopper".to_owned(), hopper.into()),
        ("scenario".to_owned(), [entry("toml", scenario)].into()),
    ]);
    let brief = Scenario::parse(scenario, "a test").unwrap().resolve().unwrap().brief;
    let brief = Brief { run: RunId(run), ..brief };
    let (_, states) = fixtures::flown();
    let state = State { run: RunId(run), ..states[run as usize] };
    let mut now = MonotonicNs(started_ns);
    let mut recorder = Recorder::new(&context, now).unwrap();
    for message in [RecordedMessage::Brief(brief), RecordedMessage::State(state)] {
        now = now.plus_ns(1_000);
        recorder.on(message, now).unwrap();
    }
    recorder.finish(now).unwrap();
    recorder.bytes()
}

/// P-BAG-MERGED: If one file holds several recordings, seed, scenario and end of the last mission
/// are its own or unknown, and a recovery keeps all metadata.
#[test]
fn two_recordings_in_one_file_keep_their_metadata_apart() {
    let folder = Folder::new();
    let [hard, coverage] = ["hard", "coverage"].map(|name| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenarios/{name}.toml"));
        std::fs::read_to_string(path).unwrap()
    });
    let first = Contents::of(&mission(&hard, 1, "11", 1_000_000));
    let second = Contents::of(&mission(&coverage, 2, "22", 2_000_000));
    let together = |parts: [&Contents; 2]| {
        let metadata = parts.iter().flat_map(|part| part.metadata.clone());
        let chunks = parts.iter().map(|part| {
            let records = [part.definitions.as_slice(), &part.messages].concat();
            chunk(&records)
        });
        file(&metadata.chain(chunks).collect::<Vec<_>>(), &[])
    };
    for parts in [[&first, &second], [&second, &first]] {
        folder.write("two.mcap", &together(parts));
        let (told, code) = folder.info("two.mcap");
        assert_eq!(
            (code, &told["runs"], &told["scenario"]),
            (Some(0), &2.into(), &"coverage".into()),
            "{told}"
        );
        assert_eq!((&told["seed"], &told["version"]), (&"22".into(), &"0.1.0".into()), "{told}");
        assert_eq!(told["digest_at_end"], told["digest"], "{told}");
        let seeds = ["hopper", "hopper#2"].map(|name| told["metadata"][name]["seed"].as_str().unwrap());
        assert!(seeds.contains(&"11") && seeds.contains(&"22"), "{told}");
        let scenario = folder.bag(&["info", "two.mcap", "--scenario"]);
        assert_eq!(String::from_utf8(scenario.stdout).unwrap(), coverage);

        let _ = std::fs::remove_file(folder.path("whole.mcap"));
        let output = folder.bag(&["recover", "two.mcap", "whole.mcap"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let (mut got, mut need) = (folder.read("whole.mcap"), folder.read("two.mcap"));
        for bytes in [&mut got, &mut need] {
            let mut records = Recording::read(bytes).unwrap().metadata_records().to_vec();
            records.sort();
            assert_eq!(records.len(), 6);
            *bytes = format!("{records:?}").into_bytes();
        }
        assert!(got == need, "every metadata record is kept");
        let (recovered, _) = folder.info("whole.mcap");
        assert_eq!((&recovered["seed"], &recovered["scenario"]), (&told["seed"], &told["scenario"]));
    }
    // A recorder that was there at the same time may have recorded the mission as well.
    let beside = Contents::of(&mission(&hard, 1, "11", 1_999_500));
    folder.write("beside.mcap", &together([&beside, &second]));
    let (told, _) = folder.info("beside.mcap");
    assert_eq!((&told["seed"], &told["version"]), (&Value::Null, &"0.1.0".into()), "{told}");
    // A recorder with one seed and two missions: the seed is that of either.
    let alone = Contents { metadata: Vec::new(), ..Contents::of(&mission(&coverage, 2, "22", 1_001_000)) };
    folder.write("alone.mcap", &together([&first, &alone]));
    let (told, _) = folder.info("alone.mcap");
    assert_eq!((&told["seed"], &told["digest_at_end"]), (&Value::Null, &Value::Null), "{told}");
    let scenario = folder.bag(&["info", "alone.mcap", "--scenario"]);
    assert_eq!((scenario.status.code(), scenario.stdout.len()), (Some(1), 0), "{}", stderr(&scenario));
}

/// P-BAG-DAMAGED: Messages that cannot be decoded are counted and left out, by every command and by
/// a recovery.
#[test]
fn messages_that_cannot_be_decoded_are_counted_and_left_out() {
    let folder = Folder::new();
    let bytes = seed();
    let Contents { metadata, definitions, messages: sent } = Contents::of(&bytes);
    let state = Contents::of(&bytes).channel("hop/state");
    let (_, states) = fixtures::flown();
    let mut absurd = states[1];
    absurd.last.as_mut().unwrap().flight.launch_angle_rad = -7.653951726284979e96;
    let message = |data: &[u8]| (MESSAGE, [&state[..], &[0; 20], data].concat());
    let damaged = [message(&RecordedMessage::State(absurd).encode()), message(b"\xff\xff\xff")];
    let data = [metadata, vec![chunk(&[definitions, damaged.to_vec(), sent].concat())]].concat();
    folder.write("damaged.mcap", &file(&data, &[]));
    folder.write("intact.mcap", &bytes);
    let (told, code) = folder.info("damaged.mcap");
    let (intact, _) = folder.info("intact.mcap");
    assert_eq!((code, &told["whole"], &told["undecodable"]), (Some(1), &true.into(), &2.into()), "{told}");
    assert_eq!((&told["digest"], &told["records"]), (&intact["digest"], &intact["records"]));
    for words in [&["export"][..], &["export", "--topic", "hop/state"], &["export", "--format", "json"]] {
        let [got, need] = ["damaged.mcap", "intact.mcap"].map(|file| folder.bag(&[words, &[file]].concat()));
        assert_eq!(got.status.code(), Some(0), "{words:?}: {}", stderr(&got));
        assert!(got.stdout == need.stdout && !need.stdout.is_empty(), "{words:?}");
        let warning = stderr(&got);
        assert!(warning.contains("2 messages cannot be decoded; the first is"), "{words:?}: {warning}");
        assert!(warning.contains("got -7.653951726284979e96") && warning.len() < 300, "{warning}");
    }
    let [got, need] = ["damaged.mcap", "intact.mcap"].map(|file| folder.bag(&["replay", file]));
    assert_eq!((got.status.code(), got.stdout.is_empty()), (need.status.code(), need.stdout.is_empty()));

    let output = folder.bag(&["recover", "damaged.mcap", "whole.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("2 messages that cannot be decoded left out"), "{}", stderr(&output));
    let whole = folder.read("whole.mcap");
    assert!(messages(&whole) == messages(&bytes));
    assert_eq!(Recording::read(&whole).unwrap().metadata["recovered"]["undecodable"], "2");
    let (told, code) = folder.info("whole.mcap");
    assert_eq!((code, &told["undecodable"]), (Some(0), &0.into()), "{told}");
}

/// P-BAG-UNKNOWN: Records of unknown kinds are skipped wherever they stand, with or without
/// checksums; a chunk with a damaged opcode is reported.
#[test]
fn records_of_unknown_kinds_are_passed_over_and_damaged_chunks_are_not() {
    let bytes = seed();
    let Contents { metadata, definitions, messages: sent } = Contents::of(&bytes);
    let all = [definitions.as_slice(), &sent].concat();
    let chunks: Vec<Record> = all.chunks(30).map(chunk).collect();
    let data = [metadata.as_slice(), &chunks].concat();
    for kind in [0x10, 0x55, 0x7e, 0x80, 0x86, 0xff] {
        let unknown = (kind, b"of another program, some thirty bytes".to_vec());
        for at in 0..=data.len() {
            let mut data = data.clone();
            data.splice(at..at, [unknown.clone(), (kind, Vec::new())]);
            let extended = file(&data, &[]);
            let recording = Recording::read(&extended).unwrap();
            assert!(recording.is_whole(), "{kind:#x} at {at}: {:?}", recording.fault);
            assert!(messages(&extended) == messages(&bytes), "{kind:#x} at {at}");
        }
        let unchunked = [vec![unknown.clone()], all.clone(), vec![unknown]].concat();
        assert!(messages(&file(&unchunked, &[])) == messages(&bytes), "{kind:#x}, no chunk");
        for at in 0..chunks.len() {
            let mut damaged = chunks.clone();
            damaged[at].0 = kind;
            let damaged = file(&damaged, &[]);
            let recording = Recording::read(&damaged).unwrap();
            assert!(recording.fault.unwrap().contains("unexpected kind"), "{kind:#x} at {at}");
        }
    }
}

/// P-BAG-OUT: An impossible recovery says what it needs, has exit code 2 and writes nothing: names
/// of other formats, directories, empty and compressed files, files without messages.
#[test]
fn a_recovery_that_cannot_be_says_what_it_needs() {
    let folder = Folder::new();
    folder.write("a.mcap", &seed());
    for out in ["x.gif", "x.svg", "x.png", "x.jpg", "x.bag", "x.mcap.gz"] {
        let refusal = folder.refusal("a.mcap", out);
        assert!(refusal.contains("need a name that ends in .mcap"), "{refusal}");
    }
    folder.write("file", b"");
    for (out, need) in [
        ("noext/", "need the name of a file, got a folder"),
        ("nofolder/x.mcap", "need a folder that exists, got nofolder"),
        ("file/x.mcap", "need a folder, got the file file"),
    ] {
        let refusal = folder.refusal("a.mcap", out);
        assert!(refusal.contains(need), "{out}: {refusal}");
    }
    let empty = Recorder::new(&Context::new(), MonotonicNs(0)).unwrap().bytes();
    for (bytes, need) in [
        (&b""[..], "got an empty file"),
        (b"\x1f\x8b\x08 and so on", "got a file compressed by gzip: decompress it first"),
        (b"\x28\xb5\x2f\xfd and so on", "got a file compressed by zstd: decompress it first"),
        (b"GIF89a and so on", "got [47, 49, 46, 38, 39, 61, 20, 61] of 16 bytes"),
        (&file(&[], &[]), "no message can be recovered, so no file is written: it has none"),
        (&empty, "no message can be recovered, so no file is written: the recording was never ended"),
        (MAGIC, "no message can be recovered, so no file is written: the recording was never ended"),
        (
            &seed()[..20],
            "no message can be recovered, so no file is written: cut in the middle of the record",
        ),
    ] {
        folder.write("b.mcap", bytes);
        let refusal = folder.refusal("b.mcap", "out.mcap");
        assert!(refusal.contains(need), "{refusal}");
    }
    let mut files: Vec<_> =
        std::fs::read_dir(&folder.0).unwrap().map(|file| file.unwrap().file_name()).collect();
    files.sort();
    assert_eq!(files, ["a.mcap", "b.mcap", "file"]);

    folder.write("b.mcap", &file(&[], &[]));
    let text = String::from_utf8(folder.bag(&["info", "b.mcap"]).stdout).unwrap();
    assert!(text.contains("mission     none: not a recording of Hopper"), "{text}");
}

/// P-ROS2-DAMAGED: Whatever bit of a recording is flipped that no checksum covers, a bag of ROS 2 is made of it or it is refused.
#[test]
fn a_damaged_recording_becomes_a_bag_or_is_refused() {
    /// One of so many bits is flipped.
    const STRIDE: usize = 2003;
    let Contents { metadata, definitions, messages } = Contents::of(&seed());
    let sound = file(&[metadata, definitions, messages].concat(), &[]);
    let conversion = ros2::Conversion { prior: &[], maps_bytes_max: 1 << 20 };
    let made_of = |bytes: &[u8]| {
        let recording = Recording::read(bytes).ok()?;
        let mission = ros2::Mission::of(&recording).ok()?;
        let mut bag = Vec::new();
        let written = ros2::convert(&recording, &mission, &conversion, &mut bag, "a_0.mcap");
        let messages: u64 = written.unwrap().summary.messages.values().sum();
        let again = Recording::read(&bag).unwrap();
        assert!(again.is_whole() && again.entries().count() as u64 == messages, "{:?}", again.fault);
        Some(messages)
    };
    let expected = made_of(&sound).unwrap();
    let (mut made, mut other) = (0, 0);
    for bit in (0..8 * sound.len()).step_by(STRIDE) {
        let mut damaged = sound.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        if let Some(messages) = made_of(&damaged) {
            made += 1;
            other += u64::from(messages != expected);
        }
    }
    assert!(made > 100 && other > 0, "{made} bags, {other} with other messages");
}
