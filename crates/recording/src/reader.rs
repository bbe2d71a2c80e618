//! Reads a recording up to its last valid record, however it was cut.

use std::collections::BTreeMap;

use contract::MonotonicNs;

use crate::layout::{self, MAGIC, kind};
use crate::{Message, RecordingError, Topic};

/// A recording in memory: what it says of itself, and where its chunks are.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    bytes: &'a [u8],
    chunks: Vec<&'a [u8]>,
    /// The metadata by name: `hopper`, `scenario`, `end` and, after a recovery, `recovered`.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// What viewers may know the contents by: `hopper`.
    pub profile: String,
    /// Bytes of whole, valid records from the beginning on.
    pub valid_bytes: u64,
    /// What is wrong after those; `None` if the file is whole.
    pub fault: Option<String>,
}

/// One message of a recording.
#[derive(Clone, Debug)]
pub struct Entry<'a> {
    /// Its number in the file, from 0.
    pub number: u64,
    /// Its topic's name.
    pub topic: String,
    /// The topic, if it is one of Hopper's with its schema.
    pub known: Option<Topic>,
    /// When the recorder had it.
    pub logged: MonotonicNs,
    /// When it was published.
    pub published: MonotonicNs,
    /// Its number on its topic.
    pub sequence: u32,
    /// Its protobuf.
    pub data: &'a [u8],
}

impl Entry<'_> {
    /// The message; `None` for a topic of others, or drawn for viewers.
    ///
    /// # Errors
    /// If it is no protobuf of its schema, or a field is out of range.
    pub fn message(&self) -> Result<Option<Message>, RecordingError> {
        let Some(topic) = self.known else { return Ok(None) };
        Message::decode(topic, self.data).map_err(|cause| RecordingError::Message {
            topic: self.topic.clone(),
            number: self.number,
            cause,
        })
    }
}

impl<'a> Recording<'a> {
    /// Looks over all records once: frames, checksums, metadata.
    ///
    /// # Errors
    /// If it does not begin as an MCAP file. Whatever is wrong later is told by [`Recording::fault`].
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

    /// Whether it was ended as it should, and is all there.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.fault.is_none()
    }

    /// Bytes after the last valid record.
    #[must_use]
    pub fn lost_bytes(&self) -> u64 {
        self.bytes.len() as u64 - self.valid_bytes
    }

    /// Valid chunks.
    #[must_use]
    pub fn chunks(&self) -> usize {
        self.chunks.len()
    }

    /// An entry of the metadata.
    #[must_use]
    pub fn told(&self, name: &str, key: &str) -> Option<&str> {
        self.metadata.get(name)?.get(key).map(String::as_str)
    }

    /// The messages of all valid chunks in the order in which they were recorded.
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
                    let known = Topic::of(&topic).filter(|known| {
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

    /// Hopper's own messages, each with the moment at which the recorder had it. One that does not decode is an
    /// error, and the next is the one after it.
    pub fn messages(&self) -> impl Iterator<Item = Result<(MonotonicNs, Message), RecordingError>> + '_ {
        self.entries().filter_map(|entry| {
            entry.message().map(|message| message.map(|message| (entry.logged, message))).transpose()
        })
    }

    /// The valid chunks' records, a chunk after another.
    pub(crate) fn chunk_records(&self) -> impl Iterator<Item = &'a [u8]> + '_ {
        self.chunks.iter().copied()
    }

    fn scan(&mut self) -> Result<(), String> {
        let (bytes, mut at, mut ended) = (self.bytes, MAGIC.len(), false);
        loop {
            if at == bytes.len() {
                return Err(format!(
                    "it was never ended: what a recording ends with is missing from byte {at} on"
                ));
            }
            let record = layout::framed(bytes, at)?;
            let told = |what: &str| format!("{what} at byte {at}");
            match record.kind {
                kind::HEADER => {
                    self.profile = layout::profile(record.body).ok_or_else(|| told("a damaged header"))?;
                }
                kind::CHUNK if !ended => {
                    let chunk = layout::chunk(record.body).map_err(|what| told(&what))?;
                    check(chunk).map_err(|what| told(&what))?;
                    self.chunks.push(chunk);
                }
                kind::METADATA if !ended => {
                    let (name, entries) =
                        layout::metadata(record.body).ok_or_else(|| told("damaged metadata"))?;
                    self.metadata.insert(name, entries);
                }
                kind::SCHEMA if layout::schema(record.body).is_some() => {}
                kind::CHANNEL if layout::channel(record.body).is_some() => {}
                kind::MESSAGE_INDEX if layout::is_message_index(record.body) => {}
                kind::ATTACHMENT => {}
                // Passing over what nobody knows would pass over a chunk whose kind was damaged.
                other if !ended && other != kind::DATA_END => {
                    return Err(told(&format!(
                        "a record of kind {other:#04x} that has no place among the data"
                    )));
                }
                kind::DATA_END => {
                    let need = layout::data_end(record.body).ok_or_else(|| told("a damaged end of data"))?;
                    let got = crc32fast::hash(&bytes[..at]);
                    if need != 0 && need != got {
                        return Err(told(&format!("data with checksum {got:08x}, which need {need:08x},")));
                    }
                    ended = true;
                }
                kind::FOOTER => {
                    if &bytes[record.end..] != MAGIC || !ended {
                        return Err("no end of the file after its footer".into());
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

/// Whether all records of a chunk are whole.
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
