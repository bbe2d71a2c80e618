//! Reads a recording up to its last valid record, even if it was cut, and whichever program wrote it.
//!
//! Messages are given in the order of their log times. Hopper records them in that order; programs that rewrite a file
//! by topic, or backwards, do not keep it.
//!
//! Records of a kind that is not known are passed over, as the specification asks, unless they may be a damaged chunk.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use contract::MonotonicNs;

use crate::compression::DECOMPRESSED_BYTES_MAX;
use crate::definitions::Definitions;
use crate::layout::{self, Framed, MAGIC, kind};
use crate::{Channel, Entry, RecordedMessage, RecordingError, SkippedMessages};

/// A recording in memory, with its metadata and its messages.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    bytes: &'a [u8],
    /// Schemas, channels and messages: those of each chunk, and those that are in none.
    sections: Vec<Cow<'a, [u8]>>,
    chunks: usize,
    attachments: usize,
    /// Whether the messages stand in the order of their log times.
    is_in_order: bool,
    /// Schemas and channels of the whole file: for each number the first one.
    definitions: Definitions,
    /// Number of messages whose channel the file does not define.
    without_channel: u64,
    /// All metadata records in the order of the file.
    metadata_records: Vec<(String, BTreeMap<String, String>)>,
    /// Metadata records by name: `hopper`, `scenario`, `end` and, after a recovery, `recovered`. Of a file with several
    /// recordings, another record of a name is `hopper#2`, and so on.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// MCAP profile of the file: `hopper`.
    pub profile: String,
    /// Length of the valid part from the beginning, bytes.
    pub valid_bytes: u64,
    /// What is wrong after the valid part, or with its channels; `None` if the file is complete.
    pub fault: Option<String>,
}

impl<'a> Recording<'a> {
    /// Scans all records once and checks framing and checksums.
    ///
    /// # Errors
    /// If the bytes do not begin like an MCAP file. Later faults are in [`Recording::fault`].
    pub fn read(bytes: &'a [u8]) -> Result<Self, RecordingError> {
        if !bytes.starts_with(MAGIC) {
            return Err(RecordingError::Magic { got: layout::other_format(bytes) });
        }
        let mut recording = Self {
            bytes,
            sections: Vec::new(),
            chunks: 0,
            attachments: 0,
            is_in_order: true,
            definitions: Definitions::default(),
            without_channel: 0,
            metadata_records: Vec::new(),
            metadata: BTreeMap::new(),
            profile: String::new(),
            valid_bytes: MAGIC.len() as u64,
            fault: None,
        };
        recording.fault = recording.scan().err();
        if recording.fault.is_some() {
            recording.define_by_summary();
        }
        recording.definitions.resolve();
        recording.metadata = recording.metadata_by_name();
        recording.without_channel = recording.count_without_channel();
        if recording.without_channel > 0 {
            let lost =
                format!("{} messages have a channel that is not in the file", recording.without_channel);
            let before = recording.fault.take().map_or_else(String::new, |fault| format!("{fault}; "));
            recording.fault = Some(before + &lost);
        }
        recording.is_in_order = is_in_order(recording.entries_as_written());
        Ok(recording)
    }

    /// Whether the file is complete and properly ended.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.fault.is_none()
    }

    /// Number of bytes after the last valid record.
    #[must_use]
    pub fn lost_bytes(&self) -> u64 {
        self.bytes.len() as u64 - self.valid_bytes
    }

    /// Number of valid chunks.
    #[must_use]
    pub fn chunks(&self) -> usize {
        self.chunks
    }

    /// Number of attachments, which are files of other programs within the recording.
    #[must_use]
    pub fn attachments(&self) -> usize {
        self.attachments
    }

    /// Number of messages that are left out, since the file does not define their channel.
    #[must_use]
    pub fn without_channel(&self) -> u64 {
        self.without_channel
    }

    /// The messages that Hopper cannot decode.
    #[must_use]
    pub fn undecodable(&self) -> SkippedMessages {
        let mut undecodable = SkippedMessages::default();
        self.entries().filter_map(|entry| entry.undecodable()).for_each(|error| undecodable.add(&error));
        undecodable
    }

    /// All metadata records with their names, in the order of the file.
    #[must_use]
    pub fn metadata_records(&self) -> &[(String, BTreeMap<String, String>)] {
        &self.metadata_records
    }

    /// The metadata records `name` in the order of the file, each once.
    #[must_use]
    pub fn metadata_named(&self, name: &str) -> Vec<&BTreeMap<String, String>> {
        let mut seen = BTreeSet::new();
        let named = self.metadata_records.iter().filter(|(known, _)| known == name);
        named.map(|(_, entries)| entries).filter(|entries| seen.insert(*entries)).collect()
    }

    /// The messages of the valid part, in the order of their log times.
    pub fn entries(&self) -> impl Iterator<Item = Entry<'_>> + '_ {
        let (recorded, sorted) = match self.is_in_order {
            true => (Some(self.entries_as_written()), Vec::new()),
            false => (None, in_order(self.entries_as_written())),
        };
        let entries = recorded.into_iter().flatten().chain(sorted);
        entries.zip(0..).map(|(entry, number)| Entry { number, ..entry })
    }

    /// The messages of the valid part, in the order of the file.
    fn entries_as_written(&self) -> impl Iterator<Item = Entry<'_>> + '_ {
        let mut definitions = self.definitions.clone();
        self.sections.iter().flat_map(|section| records(section)).filter_map(move |record| {
            if record.kind == kind::MESSAGE {
                return definitions.entry(&record);
            }
            definitions.replace(&record);
            None
        })
    }

    /// Hopper's own messages, each with the time the recorder received it. A message that cannot be decoded is an
    /// error; iteration continues after it.
    pub fn messages(
        &self,
    ) -> impl Iterator<Item = Result<(MonotonicNs, RecordedMessage), RecordingError>> + '_ {
        self.entries().filter_map(|entry| {
            entry.message().map(|message| message.map(|message| (entry.logged, message))).transpose()
        })
    }

    /// Schemas, channels and messages of the valid part, section by section, in the order of the file.
    pub(crate) fn sections(&self) -> impl Iterator<Item = &[u8]> + '_ {
        self.sections.iter().map(AsRef::as_ref)
    }

    /// Schemas and channels of the whole file: for each number the first one.
    pub(crate) fn definitions(&self) -> &Definitions {
        &self.definitions
    }

    fn count_without_channel(&self) -> u64 {
        let messages = self.sections().flat_map(records).filter(|record| record.kind == kind::MESSAGE);
        let channel = |record: Framed<'_>| layout::message(record.body).map(|(channel, ..)| channel);
        let defined = self.definitions.channels();
        messages.filter_map(channel).filter(|channel| !defined.contains_key(channel)).count() as u64
    }

    /// Takes schemas and channels of the summary of a file that is damaged before it.
    fn define_by_summary(&mut self) {
        let Some(summary) = layout::summary(self.bytes) else { return };
        records(summary).for_each(|record| self.definitions.add(&record));
    }

    /// Metadata records by name; those that have the name of another one are numbered.
    fn metadata_by_name(&self) -> BTreeMap<String, BTreeMap<String, String>> {
        let mut by_name = BTreeMap::new();
        let mut seen = BTreeSet::new();
        let mut counts = BTreeMap::<&str, u64>::new();
        for record in self.metadata_records.iter().filter(|record| seen.insert(*record)) {
            let (name, entries) = record;
            let count = counts.entry(name).or_default();
            let free = loop {
                *count += 1;
                let numbered = if *count == 1 { name.clone() } else { format!("{name}#{count}") };
                if !by_name.contains_key(&numbered) {
                    break numbered;
                }
            };
            by_name.insert(free, entries.clone());
        }
        by_name
    }

    // Long: an arm for each kind of record.
    fn scan(&mut self) -> Result<(), String> {
        let (bytes, mut at, mut ended) = (self.bytes, MAGIC.len(), false);
        let mut budget = DECOMPRESSED_BYTES_MAX;
        // Where the records that are in no chunk and have not been taken yet begin.
        let mut loose = None;
        let mut checksum = DataChecksum::Unknown;
        loop {
            if at == bytes.len() {
                self.take_loose(&mut loose, at);
                return Err(format!("the recording was never ended: its end is missing from byte {at} on"));
            }
            let record = layout::framed(bytes, at).inspect_err(|_| self.take_loose(&mut loose, at))?;
            let located = |what: &str| format!("{what} at byte {at}");
            let is_loose = match record.kind {
                kind::SCHEMA if !ended => layout::schema(record.body).is_some(),
                kind::CHANNEL if !ended => layout::channel(record.body).is_some(),
                kind::MESSAGE if !ended => layout::message(record.body).is_some(),
                _ => false,
            };
            if is_loose {
                // Beside chunks a message may be the index of a chunk with a damaged opcode.
                if record.kind == kind::MESSAGE && self.chunks > 0 && !checksum.is_right(bytes, at) {
                    self.take_loose(&mut loose, at);
                    return Err(located("a message outside of chunks, and no checksum that proves it,"));
                }
                self.definitions.add(&record);
                loose.get_or_insert(at);
                at = record.end;
                self.valid_bytes = at as u64;
                continue;
            }
            self.take_loose(&mut loose, at);
            match record.kind {
                kind::HEADER => {
                    self.profile = layout::profile(record.body).ok_or_else(|| located("a damaged header"))?;
                }
                kind::CHUNK if !ended => {
                    let chunk = layout::chunk(record.body, budget).map_err(|what| located(&what))?;
                    check(&chunk).map_err(|what| located(&what))?;
                    if let Cow::Owned(records) = &chunk {
                        budget -= records.len() as u64;
                    }
                    self.chunks += 1;
                    records(&chunk).for_each(|record| self.definitions.add(&record));
                    self.sections.push(chunk);
                }
                kind::METADATA if !ended => {
                    let (name, entries) =
                        layout::metadata(record.body).ok_or_else(|| located("damaged metadata"))?;
                    self.metadata_records.push((name, entries));
                }
                kind::SCHEMA if layout::schema(record.body).is_some() => self.definitions.add(&record),
                kind::CHANNEL if layout::channel(record.body).is_some() => self.definitions.add(&record),
                kind::MESSAGE_INDEX if layout::is_message_index(record.body) => {}
                kind::ATTACHMENT => self.attachments += 1,
                // An unknown record may be a chunk with a damaged opcode, unless a checksum or its form proves
                // that it is none.
                other if !ended && other > kind::KNOWN_MAX && checksum.is_right(bytes, at) => {}
                other if !ended && other > kind::KNOWN_MAX => {
                    let known_at = after_unknown(bytes, at, self.chunks > 0);
                    at = known_at.ok_or_else(|| located(&unexpected(other)))?;
                    self.valid_bytes = at as u64;
                    continue;
                }
                other if !ended && other != kind::DATA_END => {
                    return Err(located(&unexpected(other)));
                }
                kind::DATA_END => {
                    let need =
                        layout::data_end(record.body).ok_or_else(|| located("a damaged end of data"))?;
                    let got = crc32fast::hash(&bytes[..at]);
                    if need != 0 && need != got {
                        return Err(located(&format!("data with checksum {got:08x}, need {need:08x},")));
                    }
                    ended = true;
                }
                kind::FOOTER => {
                    if &bytes[record.end..] != MAGIC || !ended {
                        return Err("a footer that is not followed by the end of the file".into());
                    }
                    self.valid_bytes = bytes.len() as u64;
                    return Ok(());
                }
                _ => {}
            }
            at = record.end;
            self.valid_bytes = at as u64;
        }
    }

    /// Takes the records from `loose` to `end`, which are in no chunk, as a section.
    fn take_loose(&mut self, loose: &mut Option<usize>, end: usize) {
        if let Some(from) = loose.take() {
            self.sections.push(Cow::Borrowed(&self.bytes[from..end]));
        }
    }
}

/// Whether the data of a file has the checksum that the end of its data tells. Computed at most once.
enum DataChecksum {
    Unknown,
    Known(bool),
}

impl DataChecksum {
    /// Whether there is a checksum, and it is right. `at` is where a record of the data begins.
    fn is_right(&mut self, bytes: &[u8], mut at: usize) -> bool {
        if let Self::Known(is_right) = self {
            return *is_right;
        }
        let mut is_right = false;
        while let Ok(record) = layout::framed(bytes, at) {
            if record.kind == kind::DATA_END {
                let need = layout::data_end(record.body).unwrap_or(0);
                is_right = need != 0 && need == crc32fast::hash(&bytes[..at]);
                break;
            }
            at = record.end;
        }
        *self = Self::Known(is_right);
        is_right
    }
}

fn unexpected(kind: u8) -> String {
    format!("a record of unexpected kind {kind:#04x} in the data")
}

/// Where the first record of a known kind after those of unknown kinds at byte `at` begins; `None` if one of these
/// has the form of a chunk, or what follows is no record that stands in the data. An index of messages
/// follows chunks only. Beside chunks, a message outside of them proves nothing.
fn after_unknown(bytes: &[u8], mut at: usize, has_chunks: bool) -> Option<usize> {
    loop {
        let record = layout::framed(bytes, at).ok()?;
        let is_known = match record.kind {
            kind::SCHEMA => layout::schema(record.body).is_some(),
            kind::CHANNEL => layout::channel(record.body).is_some(),
            kind::MESSAGE => !has_chunks && layout::message(record.body).is_some(),
            kind::CHUNK => layout::is_chunk(record.body),
            kind::METADATA => layout::metadata(record.body).is_some(),
            kind::DATA_END => layout::data_end(record.body).is_some(),
            kind::ATTACHMENT => true,
            _ => false,
        };
        if is_known {
            return Some(at);
        }
        if record.kind <= kind::KNOWN_MAX || layout::is_chunk(record.body) {
            return None;
        }
        at = record.end;
    }
}

/// Whether messages stand in the order of their log times and, where these are equal, of their numbers on each channel.
fn is_in_order<'a>(entries: impl Iterator<Item = Entry<'a>>) -> bool {
    let mut logged = MonotonicNs(0);
    // Of the messages with that log time the last number on each channel.
    let mut sequences = BTreeMap::new();
    for entry in entries {
        if entry.logged < logged {
            return false;
        }
        if entry.logged > logged {
            sequences.clear();
        }
        logged = entry.logged;
        if sequences.insert(entry.topic, entry.sequence).is_some_and(|last| entry.sequence < last) {
            return false;
        }
    }
    true
}

/// The messages in the order in which they were recorded, as far as it is known: by log time, then by cause.
fn in_order<'a>(entries: impl Iterator<Item = Entry<'a>>) -> Vec<Entry<'a>> {
    let mut entries: Vec<_> = entries.collect();
    entries.sort_by_key(|entry| {
        // What follows from a brief means nothing before it.
        let is_brief = entry.known == Some(Channel::Brief);
        (entry.logged, !is_brief, entry.published, entry.sequence)
    });
    entries
}

/// The records of a checked chunk.
pub(crate) fn records(chunk: &[u8]) -> impl Iterator<Item = layout::Framed<'_>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let record = layout::framed(chunk, at).ok()?;
        at = record.end;
        Some(record)
    })
}

/// Checks that all records of a chunk are complete.
fn check(chunk: &[u8]) -> Result<(), String> {
    let mut at = 0;
    while at < chunk.len() {
        let record = layout::framed(chunk, at).map_err(|what| format!("a chunk whose record is {what}"))?;
        let is_whole = match record.kind {
            kind::SCHEMA => layout::schema(record.body).is_some(),
            kind::CHANNEL => layout::channel(record.body).is_some(),
            kind::MESSAGE => layout::message(record.body).is_some(),
            _ => true,
        };
        if !is_whole {
            return Err("a chunk with a damaged record".into());
        }
        at = record.end;
    }
    Ok(())
}
