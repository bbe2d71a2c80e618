//! Reads a recording up to its last valid record, even if it was cut.

use std::collections::BTreeMap;

use contract::MonotonicNs;

use crate::layout::{self, MAGIC, kind};
use crate::{Channel, RecordedMessage, RecordingError};

/// A recording in memory, with its metadata and the positions of its chunks.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    bytes: &'a [u8],
    chunks: Vec<&'a [u8]>,
    /// Metadata records by name: `hopper`, `scenario`, `end` and, after a recovery, `recovered`.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// MCAP profile of the file: `hopper`.
    pub profile: String,
    /// Length of the valid part from the beginning, bytes.
    pub valid_bytes: u64,
    /// What is wrong after the valid part; `None` if the file is complete.
    pub fault: Option<String>,
}

/// One message of a recording.
#[derive(Clone, Debug)]
pub struct Entry<'a> {
    /// Number in the file, from 0.
    pub number: u64,
    /// Topic it was recorded on.
    pub topic: String,
    /// The channel, if it is one of Hopper's with the expected schema.
    pub known: Option<Channel>,
    /// When the recorder received it.
    pub logged: MonotonicNs,
    /// When it was published, or `logged` if the message has no such time.
    pub published: MonotonicNs,
    /// Number on its channel, from 0.
    pub sequence: u32,
    /// Its protobuf encoding.
    pub data: &'a [u8],
}

impl Entry<'_> {
    /// The decoded message; `None` on channels of other programs and on those made for viewers.
    ///
    /// # Errors
    /// If it is not protobuf of its schema, or a field is out of range.
    pub fn message(&self) -> Result<Option<RecordedMessage>, RecordingError> {
        let Some(topic) = self.known else { return Ok(None) };
        RecordedMessage::decode(topic, self.data).map_err(|cause| RecordingError::Message {
            topic: self.topic.clone(),
            number: self.number,
            cause,
        })
    }
}

impl<'a> Recording<'a> {
    /// Scans all records once and checks framing and checksums.
    ///
    /// # Errors
    /// If the bytes do not begin like an MCAP file. Later faults are in [`Recording::fault`].
    pub fn read(bytes: &'a [u8]) -> Result<Self, RecordingError> {
        if !bytes.starts_with(MAGIC) {
            let head = &bytes[..bytes.len().min(MAGIC.len())];
            return Err(RecordingError::Magic { got: format!("{head:02x?} of {} bytes", bytes.len()) });
        }
        let mut recording = Self {
            bytes,
            chunks: Vec::new(),
            metadata: BTreeMap::new(),
            profile: String::new(),
            valid_bytes: MAGIC.len() as u64,
            fault: None,
        };
        recording.fault = recording.scan().err();
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
        self.chunks.len()
    }

    /// The value of `key` in the metadata record `name`.
    #[must_use]
    pub fn metadata_entry(&self, name: &str, key: &str) -> Option<&str> {
        self.metadata.get(name)?.get(key).map(String::as_str)
    }

    /// The messages of all valid chunks, in the order they were recorded.
    pub fn entries(&self) -> impl Iterator<Item = Entry<'a>> + '_ {
        let mut channels = BTreeMap::new();
        let mut schemas = BTreeMap::new();
        let messages = self.chunks.iter().flat_map(|chunk| records(chunk)).filter_map(move |record| {
            match record.kind {
                kind::SCHEMA => {
                    let (id, name, ..) = layout::schema(record.body)?;
                    schemas.insert(id, name);
                }
                kind::CHANNEL => {
                    let (id, schema, topic, encoding) = layout::channel(record.body)?;
                    let known = Channel::of(&topic).filter(|known| {
                        encoding == "protobuf"
                            && schemas.get(&schema).map(String::as_str) == Some(known.schema())
                    });
                    channels.insert(id, (topic, known));
                }
                kind::MESSAGE => {
                    let (channel, sequence, logged, published, data) = layout::message(record.body)?;
                    let (topic, known) = channels.get(&channel)?;
                    return Some(Entry {
                        number: 0,
                        topic: topic.clone(),
                        known: *known,
                        logged: MonotonicNs(logged),
                        published: MonotonicNs(published),
                        sequence,
                        data,
                    });
                }
                _ => {}
            }
            None
        });
        messages.zip(0..).map(|(entry, number)| Entry { number, ..entry })
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

    /// The records of each valid chunk.
    pub(crate) fn chunk_records(&self) -> impl Iterator<Item = &'a [u8]> + '_ {
        self.chunks.iter().copied()
    }

    fn scan(&mut self) -> Result<(), String> {
        let (bytes, mut at, mut ended) = (self.bytes, MAGIC.len(), false);
        loop {
            if at == bytes.len() {
                return Err(format!("the recording was never ended: its end is missing from byte {at} on"));
            }
            let record = layout::framed(bytes, at)?;
            let located = |what: &str| format!("{what} at byte {at}");
            match record.kind {
                kind::HEADER => {
                    self.profile = layout::profile(record.body).ok_or_else(|| located("a damaged header"))?;
                }
                kind::CHUNK if !ended => {
                    let chunk = layout::chunk(record.body).map_err(|what| located(&what))?;
                    check(chunk).map_err(|what| located(&what))?;
                    self.chunks.push(chunk);
                }
                kind::METADATA if !ended => {
                    let (name, entries) =
                        layout::metadata(record.body).ok_or_else(|| located("damaged metadata"))?;
                    self.metadata.insert(name, entries);
                }
                kind::SCHEMA if layout::schema(record.body).is_some() => {}
                kind::CHANNEL if layout::channel(record.body).is_some() => {}
                kind::MESSAGE_INDEX if layout::is_message_index(record.body) => {}
                kind::ATTACHMENT => {}
                // Unknown records are not skipped: one may be a chunk whose opcode was damaged.
                other if !ended && other != kind::DATA_END => {
                    return Err(located(&format!("a record of unexpected kind {other:#04x} in the data")));
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
