//! The MCAP file of a bag, and its `metadata.yaml`.
//!
//! The metadata is of version 5, which has all that a bag needs and which every release from Humble on reads.

use std::collections::BTreeMap;
use std::io::Write;

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};

use crate::message::{Message, definition};
use crate::{Qos, Ros2Error, cdr};

/// Size at which a chunk is closed, bytes.
const CHUNK_BYTES: u64 = 4 << 20;

/// A bag that is being written.
pub struct Bag<W: Write> {
    writer: Writer<NoSeek<W>>,
    file_name: String,
    topics: BTreeMap<String, Topic>,
    /// First and last time of a message, nanoseconds.
    span_ns: Option<(u64, u64)>,
}

#[derive(Debug)]
struct Topic {
    channel: u16,
    type_name: String,
    qos: Qos,
    messages: u64,
}

/// What a bag holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagSummary {
    /// The text of `metadata.yaml`.
    pub metadata: String,
    /// Number of messages of each topic.
    pub messages: BTreeMap<String, u64>,
}

impl<W: Write> Bag<W> {
    /// A bag whose MCAP file, of that name in the bag's folder, is written to `out`. `notes` are kept in it under the name
    /// `hopper`.
    ///
    /// # Errors
    /// If it cannot be written; the same applies to all methods.
    pub fn new(out: W, file_name: &str, notes: BTreeMap<String, String>) -> Result<Self, Ros2Error> {
        let options = WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true)
            .profile("ros2")
            .library(concat!("hopper ", env!("CARGO_PKG_VERSION"), ", ", "mcap-rust"));
        let mut writer = options.create(NoSeek::new(out))?;
        writer.write_metadata(&Metadata { name: "hopper".into(), metadata: notes })?;
        Ok(Self { writer, file_name: file_name.to_owned(), topics: BTreeMap::new(), span_ns: None })
    }

    /// Writes a message that was received at `logged_ns` since the beginning of 1970. A topic begins with its first message.
    pub fn write<M: Message>(
        &mut self,
        topic: &str,
        qos: Qos,
        logged_ns: u64,
        message: &M,
    ) -> Result<(), Ros2Error> {
        let data = cdr::encode(message)?;
        let topic = match self.topics.get_mut(topic) {
            Some(known) => known,
            None => {
                let type_name = M::type_name();
                let schema = self.writer.add_schema(&type_name, "ros2msg", definition::<M>().as_bytes())?;
                let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), qos.profiles())]);
                let channel = self.writer.add_channel(schema, topic, "cdr", &metadata)?;
                self.topics.entry(topic.to_owned()).or_insert(Topic { channel, type_name, qos, messages: 0 })
            }
        };
        let header = MessageHeader {
            channel_id: topic.channel,
            sequence: topic.messages as u32,
            log_time: logged_ns,
            publish_time: logged_ns,
        };
        topic.messages += 1;
        let (first_ns, last_ns) = self.span_ns.unwrap_or((logged_ns, logged_ns));
        self.span_ns = Some((first_ns.min(logged_ns), last_ns.max(logged_ns)));
        Ok(self.writer.write_to_known_channel(&header, &data)?)
    }

    /// Ends the file.
    pub fn finish(mut self) -> Result<BagSummary, Ros2Error> {
        let body = self.metadata();
        // Where rosbag2 looks for it if it is given the file alone.
        let entries = BTreeMap::from([("serialized_metadata".to_owned(), body.clone())]);
        self.writer.write_metadata(&Metadata { name: "rosbag2".into(), metadata: entries })?;
        self.writer.finish()?;
        let lines = body.lines().map(|line| format!("  {line}\n")).collect::<String>();
        let metadata = format!("rosbag2_bagfile_information:\n{lines}");
        let messages = self.topics.into_iter().map(|(name, topic)| (name, topic.messages)).collect();
        Ok(BagSummary { metadata, messages })
    }

    fn metadata(&self) -> String {
        let (first_ns, last_ns) = self.span_ns.unwrap_or_default();
        let count: u64 = self.topics.values().map(|topic| topic.messages).sum();
        let file = quoted(&self.file_name);
        let begins = format!("starting_time:\n  nanoseconds_since_epoch: {first_ns}\n");
        let lasts = format!("duration:\n  nanoseconds: {}\n", last_ns - first_ns);
        let counted = format!("message_count: {count}\n");
        let mut text = format!("version: 5\nstorage_identifier: mcap\n{lasts}{begins}{counted}");
        text += "topics_with_message_count:\n";
        for (name, topic) in &self.topics {
            text += &format!(
                "  - topic_metadata:\n      name: {}\n      type: {}\n      serialization_format: cdr\n      offered_qos_profiles: {}\n    message_count: {}\n",
                quoted(name),
                topic.type_name,
                quoted(&topic.qos.profiles()),
                topic.messages
            );
        }
        text += "compression_format: \"\"\ncompression_mode: \"\"\n";
        text += &format!("relative_file_paths:\n  - {file}\nfiles:\n");
        let of_file = format!("path: {file}\n{begins}{lasts}{counted}");
        for (number, line) in of_file.lines().enumerate() {
            text += &format!("  {} {line}\n", if number == 0 { "-" } else { " " });
        }
        text
    }
}

/// A text in YAML: JSON's quotation is one of YAML's.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
