//! Turns messages into the bytes of an MCAP file.
//!
//! What is written is decided by [`Transcript`]. A chunk is closed every half second, so a process that appends the bytes
//! at once loses no more than that when killed.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use contract::{Decision, MonotonicNs, RunId};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};

use crate::output_buffer::OutputBuffer;
use crate::transcript::Topic;
use crate::{Channel, JsonMessage, RecordedMessage, RecordingError, Requests, Transcript};

/// Time after which a chunk is closed, nanoseconds.
pub const CHUNK_NS: u64 = 500_000_000;

/// Size at which a chunk is closed early, bytes.
const CHUNK_BYTES: u64 = 4 << 20;

/// Metadata known before the first message: name of the record to its entries.
pub type Context = BTreeMap<String, BTreeMap<String, String>>;

/// Records missions, one after another, into one file.
pub struct Recorder {
    transcript: Transcript,
    writer: Writer<NoSeek<OutputBuffer>>,
    out: OutputBuffer,
    /// MCAP id and number of messages of each channel, in the order of [`Channel::ALL`].
    channels: Vec<(u16, u32)>,
    /// MCAP id and number of messages of each channel that is not in [`Channel::ALL`], by topic. A
    /// channel is added with its first message.
    other_channels: BTreeMap<String, (u16, u32)>,
    closed: MonotonicNs,
    /// The decisions before this, of the past of that number, have their records among the bytes given out.
    flushed: (u64, Decision),
    /// Number of the run's routes among the bytes given out.
    flushed_routes: usize,
    /// Number of the run's details among the bytes given out.
    flushed_details: usize,
    finished: bool,
}

/// Writer options of every recording.
pub(crate) fn options() -> WriteOptions {
    WriteOptions::new()
        .compression(None)
        .chunk_size(Some(CHUNK_BYTES))
        .disable_seeking(true)
        .library(concat!("hopper ", env!("CARGO_PKG_VERSION"), ", ", "mcap-rust"))
}

impl Recorder {
    /// A recorder that has written the beginning of its file: metadata, schemas, channels.
    ///
    /// # Errors
    /// If the MCAP writer fails; the same applies to all methods that write.
    pub fn new(context: &Context, now: MonotonicNs) -> Result<Self, RecordingError> {
        let out = OutputBuffer::default();
        let mut writer = options().profile("hopper").create(NoSeek::new(out.clone()))?;
        for (name, metadata) in context {
            writer.write_metadata(&Metadata { name: name.clone(), metadata: metadata.clone() })?;
        }
        let mut channels = Vec::new();
        for topic in Channel::ALL {
            channels.push((add_channel(&mut writer, &Topic::Known(topic))?, 0));
        }
        writer.flush()?;
        Ok(Self {
            transcript: Transcript::default(),
            writer,
            out,
            channels,
            other_channels: BTreeMap::new(),
            closed: now,
            flushed: (0, Decision(0)),
            flushed_routes: 0,
            flushed_details: 0,
            finished: false,
        })
    }

    /// The bytes to append to the file, written since the last call.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        self.out.take()
    }

    /// Records a message received at `now`: see [`Transcript::on`].
    pub fn on(&mut self, message: RecordedMessage, now: MonotonicNs) -> Result<Requests, RecordingError> {
        self.with(|transcript| transcript.on(message, now))
    }

    /// Passes the transcript to `tell` and writes what follows from it; returns what `tell` returns.
    pub fn with<T>(&mut self, tell: impl FnOnce(&mut Transcript) -> T) -> Result<T, RecordingError> {
        let answer = tell(&mut self.transcript);
        self.write()?;
        Ok(answer)
    }

    /// Records a message that has no schema of ours, received at `now`.
    pub fn on_json(&mut self, message: &JsonMessage, now: MonotonicNs) -> Result<(), RecordingError> {
        self.with(|transcript| transcript.on_json(message, now))
    }

    /// Lets time pass: closes the chunk if it is due, and returns the requests that are due.
    pub fn tick(&mut self, now: MonotonicNs) -> Result<Requests, RecordingError> {
        let requests = self.with(|transcript| transcript.tick(now))?;
        // The end of a mission is acknowledged once its last record is in the file, so it does not wait for its chunk.
        let (written, routes) = (self.transcript.written(), self.transcript.routes_written());
        let details = self.transcript.details_written();
        let is_flushed =
            (self.flushed, self.flushed_routes, self.flushed_details) == (written, routes, details);
        if now.since_ns(self.closed) >= CHUNK_NS || self.transcript.is_complete() && !is_flushed {
            self.closed = now;
            self.writer.flush()?;
            (self.flushed, self.flushed_routes, self.flushed_details) = (written, routes, details);
        }
        Ok(requests)
    }

    /// Whether the record of every decision of `run` before `decision`, with every route and detail that came, is among the bytes given out, and not only in a
    /// chunk that is still open.
    #[must_use]
    pub fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        let (past, flushed) = self.flushed;
        let has_records = past == self.transcript.written().0 && flushed >= decision;
        let has_routes = self.flushed_routes == self.transcript.routes_written();
        let has_details = self.flushed_details == self.transcript.details_written();
        self.transcript.run() == Some(run) && has_records && has_routes && has_details
    }

    /// Whether the expected speeds of uncertain ground are still to come.
    #[must_use]
    pub fn lacks_prior(&self) -> bool {
        self.transcript.lacks_prior()
    }

    /// Whether the points of routes that robots announced are still to come.
    #[must_use]
    pub fn lacks_routes(&self) -> bool {
        self.transcript.lacks_routes()
    }

    /// Whether what the motion model told of some decision is still to come.
    #[must_use]
    pub fn lacks_details(&self) -> bool {
        self.transcript.lacks_details()
    }

    /// Number of missing messages so far, by topic.
    #[must_use]
    pub fn missing(&self) -> &BTreeMap<String, u64> {
        self.transcript.missing()
    }

    /// Ends the file with the last chunk, the digest of the last state, and the index. Later messages are ignored.
    pub fn finish(&mut self, now: MonotonicNs) -> Result<(), RecordingError> {
        if self.finished {
            return Ok(());
        }
        self.with(|transcript| transcript.finish(now))?;
        self.finished = true;
        let mut entries = BTreeMap::from([("ended_ns".to_owned(), now.0.to_string())]);
        if let Some(state) = self.transcript.state() {
            entries.insert("run".into(), state.run.to_string());
            entries.insert("digest".into(), state.digest.to_string());
            entries.insert("decision".into(), state.decision.to_string());
            entries.insert("status".into(), state.status.to_string());
            entries.insert("records_through".into(), self.transcript.written().1.to_string());
        }
        for (topic, missing) in self.transcript.missing() {
            entries.insert(format!("missing {topic}"), missing.to_string());
        }
        self.writer.write_metadata(&Metadata { name: "end".into(), metadata: entries })?;
        self.writer.finish()?;
        Ok(())
    }

    /// Writes what the transcript has.
    fn write(&mut self) -> Result<(), RecordingError> {
        for message in self.transcript.take() {
            if self.finished {
                continue;
            }
            let (channel_id, count) = match &message.topic {
                Topic::Known(channel) => &mut self.channels[channel.place()],
                topic => match self.other_channels.entry(topic.name()) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(new) => {
                        let id = add_channel(&mut self.writer, topic)?;
                        new.insert((id, 0))
                    }
                },
            };
            let header = MessageHeader {
                channel_id: *channel_id,
                sequence: *count,
                log_time: message.logged.0,
                publish_time: message.published.0,
            };
            *count = count.wrapping_add(1);
            self.writer.write_to_known_channel(&header, &message.data)?;
        }
        Ok(())
    }
}

fn add_channel(writer: &mut Writer<NoSeek<OutputBuffer>>, topic: &Topic) -> Result<u16, RecordingError> {
    let (schema, encoding) = match topic.schema() {
        Some(channel) => {
            (writer.add_schema(channel.schema(), "protobuf", channel.descriptors())?, "protobuf")
        }
        // Schema 0: JSON describes itself.
        None => (0, "json"),
    };
    Ok(writer.add_channel(schema, &topic.name(), encoding, &BTreeMap::new())?)
}
