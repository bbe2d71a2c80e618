//! Recordings that other programs have written again: compressed, without chunks, in another order.

use std::io::Write as _;

use contract::MonotonicNs;
use recording::compression::{CHUNK_BYTES_MAX, DECOMPRESSED_BYTES_MAX};
use recording::{Channel, Playback, Recording, last_run, recover};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
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

/// Metadata, and then schemas, channels and messages, of a recording of Hopper's.
fn contents(bytes: &[u8]) -> (Vec<Record>, Vec<Record>) {
    let all = records(&bytes[MAGIC.len()..bytes.len() - MAGIC.len()]);
    let metadata = all.iter().filter(|(kind, _)| *kind == METADATA).cloned().collect();
    // Times and size, checksum, no compression, length.
    const CHUNK_HEADER_BYTES: usize = 24 + 4 + 4 + 8;
    let chunks = all.iter().filter(|(kind, _)| *kind == CHUNK);
    (metadata, chunks.flat_map(|(_, body)| records(&body[CHUNK_HEADER_BYTES..])).collect())
}

/// How a file is written.
#[derive(Clone, Copy, Debug)]
struct Layout {
    /// Compression of chunks; without chunks if there is none.
    chunks: Option<&'static str>,
    /// Records in a chunk.
    length: usize,
    /// Whether chunks and data have checksums.
    checksums: bool,
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
}

fn lz4(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn chunk(compression: &str, size: u64, checksum: u32, stored: &[u8]) -> Record {
    let mut body = vec![0; 16];
    body.extend(size.to_le_bytes());
    body.extend(checksum.to_le_bytes());
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend((stored.len() as u64).to_le_bytes());
    body.extend(stored);
    (CHUNK, body)
}

/// A file of `data`, records of the data section, without a summary.
fn file(data: &[Record], checksum: bool) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(framed(&(HEADER, [0; 8].to_vec())));
    data.iter().for_each(|record| bytes.extend(framed(record)));
    let sum = if checksum { crc32fast::hash(&bytes) } else { 0 };
    bytes.extend(framed(&(DATA_END, sum.to_le_bytes().to_vec())));
    bytes.extend(framed(&(FOOTER, vec![0; 20])));
    bytes.extend(MAGIC);
    bytes
}

fn written(metadata: &[Record], data: &[Record], layout: Layout) -> Vec<u8> {
    let Some(compression) = layout.chunks else {
        return file(&[metadata, data].concat(), layout.checksums);
    };
    let chunks = data.chunks(layout.length).map(|records| {
        let plain: Vec<u8> = records.iter().flat_map(framed).collect();
        let stored = match compression {
            "zstd" => zstd(&plain),
            "lz4" => lz4(&plain),
            _ => plain.clone(),
        };
        let checksum = if layout.checksums { crc32fast::hash(&plain) } else { 0 };
        chunk(compression, plain.len() as u64, checksum, &stored)
    });
    file(&[metadata.to_vec(), chunks.collect()].concat(), layout.checksums)
}

/// Topic, log time and data of every message, in the order of the reader.
fn messages(bytes: &[u8]) -> Vec<(String, MonotonicNs, Vec<u8>)> {
    let recording = Recording::read(bytes).unwrap();
    recording.entries().map(|entry| (entry.topic, entry.logged, entry.data.to_vec())).collect()
}

/// The decisions that are posed when the recording is played, with their maps.
fn posed(bytes: &[u8]) -> Vec<(u64, u64)> {
    let recording = Recording::read(bytes).unwrap();
    let mut playback = Playback::default();
    let mut posed = Vec::new();
    for message in recording.messages() {
        let (logged, message) = message.unwrap();
        posed.extend(playback.on(&message, logged).map(|due| (due.state.decision.0, due.map.observation())));
    }
    posed
}

fn seed() -> Vec<u8> {
    hostile::recording::seeds().remove(0)
}

/// P-BAG-OTHERS: Recordings written by other programs are read and recovered: compressed by zstd or
/// lz4, without chunks, with or without checksums and summary, damaged ones up to their last whole
/// chunk.
#[test]
fn a_recording_is_read_however_it_is_packed() {
    let bytes = seed();
    let (metadata, data) = contents(&bytes);
    let need = messages(&bytes);
    for chunks in [None, Some(""), Some("zstd"), Some("lz4")] {
        for (length, checksums) in [(1, true), (7, false), (data.len(), true)] {
            let layout = Layout { chunks, length, checksums };
            let packed = written(&metadata, &data, layout);
            let recording = Recording::read(&packed).unwrap();
            assert!(recording.is_whole(), "{layout:?}: {:?}", recording.fault);
            assert_eq!(messages(&packed), need, "{layout:?}");
            assert_eq!(recording.metadata, Recording::read(&bytes).unwrap().metadata, "{layout:?}");
            let whole = recover(&recording).unwrap();
            assert!(Recording::read(&whole).unwrap().is_whole());
            assert_eq!(messages(&whole), need, "{layout:?}");
        }
    }
    // Several frames in a chunk, of blocks of different sizes, are one stream.
    let plain: Vec<u8> = data.iter().flat_map(framed).collect();
    let (first, second) = plain.split_at(plain.len() / 3);
    for (name, stored) in
        [("lz4", [lz4(first), lz4(second)].concat()), ("zstd", [zstd(first), zstd(second)].concat())]
    {
        let packed = file(&[chunk(name, plain.len() as u64, 0, &stored)], true);
        assert_eq!(messages(&packed), need, "{name}");
    }
}

/// P-BAG-OTHERS. Messages outside of chunks are read where a checksum proves them, and so are
/// records of other programs.
#[test]
fn what_is_in_no_chunk_is_read_where_a_checksum_proves_it() {
    let bytes = seed();
    let (_, data) = contents(&bytes);
    let (first, second) = data.split_at(data.len() / 2);
    let plain: Vec<u8> = first.iter().flat_map(framed).collect();
    let private = (0x85, b"of another program".to_vec());
    let packed = [vec![chunk("", plain.len() as u64, 0, &plain), private], second.to_vec()].concat();
    assert_eq!(messages(&file(&packed, true)), messages(&bytes));
    let unproven = file(&packed, false);
    let recording = Recording::read(&unproven).unwrap();
    assert!(recording.fault.as_deref().unwrap().contains("kind 0x85"), "{:?}", recording.fault);
    assert_eq!(recording.chunks(), 1);
}

/// P-BAG-ORDER: Messages in another order are read in the order in which they were recorded.
#[test]
fn messages_in_another_order_are_read_in_the_order_of_their_log_times() {
    let bytes = seed();
    let (metadata, data) = contents(&bytes);
    let (mut channels, messages): (Vec<Record>, Vec<Record>) =
        data.into_iter().partition(|(kind, _)| [SCHEMA, CHANNEL].contains(kind));
    channels.sort_by_key(|(kind, _)| *kind);
    let backwards = messages.iter().rev().cloned().collect();
    let mut by_channel = messages.clone();
    by_channel.sort_by_key(|(_, body)| std::cmp::Reverse([body[0], body[1]]));
    let mut shuffled = messages.clone();
    shuffled.sort_by_key(|(_, body)| crc32fast::hash(body));
    let need = last_run(&Recording::read(&bytes).unwrap()).unwrap();
    for order in [messages, backwards, by_channel, shuffled] {
        let data = [channels.clone(), order].concat();
        let packed = written(&metadata, &data, Layout { chunks: Some("zstd"), length: 20, checksums: true });
        let recording = Recording::read(&packed).unwrap();
        let times: Vec<MonotonicNs> = recording.entries().map(|entry| entry.logged).collect();
        assert!(times.is_sorted());
        let got = last_run(&recording).unwrap();
        assert_eq!((got.brief, got.state, &got.records), (need.brief.clone(), need.state, &need.records));
        assert_eq!(got.decisions, need.decisions);
        assert_eq!(posed(&packed), posed(&bytes));
        assert!(recording.entries().any(|entry| entry.known == Some(Channel::Brief)));
    }
}

/// P-BAG-BOMB: A chunk that would grow beyond its declared size, or beyond the limit of a
/// recording, is refused before it takes that memory; an unknown compression is refused by name.
#[test]
fn a_chunk_that_grows_beyond_its_size_or_is_packed_otherwise_is_refused_by_name() {
    let zeros = vec![0; 1 << 22];
    let fault = |data: &[Record]| {
        let bytes = file(data, true);
        let recording = Recording::read(&bytes).unwrap();
        assert_eq!(recording.entries().count(), 0);
        recording.fault.clone().unwrap()
    };
    for (name, stored) in [("zstd", zstd(&zeros)), ("lz4", lz4(&zeros))] {
        for size in [0, 100, (1 << 22) - 1, (1 << 22) + 1] {
            let told = fault(&[chunk(name, size, 0, &stored)]);
            assert!(told.contains(name) || told.contains("length differs"), "{told}");
        }
        let told = fault(&[chunk(name, CHUNK_BYTES_MAX + 1, 0, &stored)]);
        assert!(told.contains(&format!("need {CHUNK_BYTES_MAX} at most")), "{told}");
        let told = fault(&[chunk(name, u64::MAX, 0, &stored)]);
        assert!(told.contains("at most"), "{told}");
    }
    const { assert!(CHUNK_BYTES_MAX < DECOMPRESSED_BYTES_MAX) };
    for other in ["snappy", "bz2", "ZSTD", "none"] {
        let told = fault(&[chunk(other, 4, 0, b"data")]);
        assert!(told.contains(&format!("compressed by {other:?}, need zstd, lz4 or none")), "{told}");
    }
}

/// P-BAG-OTHERS. A compressed recording that is damaged or cut is read up to its last whole chunk,
/// and reported as damaged.
#[test]
fn a_damaged_compressed_recording_is_read_up_to_its_last_whole_chunk() {
    let bytes = seed();
    let (metadata, data) = contents(&bytes);
    let need = messages(&bytes);
    for name in ["zstd", "lz4"] {
        let packed = written(&metadata, &data, Layout { chunks: Some(name), length: 40, checksums: true });
        for at in (0..packed.len()).step_by(97) {
            let cut = messages_or_none(&packed[..at]);
            assert_eq!(cut, need[..cut.len()], "{name} cut at {at}");
            let mut damaged = packed.clone();
            damaged[at] ^= 1 << (at % 8);
            let read = messages_or_none(&damaged);
            assert_eq!(read, need[..read.len()], "{name} damaged at {at}");
        }
    }
}

fn messages_or_none(bytes: &[u8]) -> Vec<(String, MonotonicNs, Vec<u8>)> {
    if Recording::read(bytes).is_ok() { messages(bytes) } else { Vec::new() }
}
