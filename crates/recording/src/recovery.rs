//! Completes a cut recording: everything up to the last valid record, with the missing index.

use std::collections::BTreeMap;

use mcap::records::{MessageHeader, Metadata};

use crate::definitions::{ChannelDefinition, Definitions};
use crate::layout::{self, kind};
use crate::output_buffer::OutputBuffer;
use crate::reader::records;
use crate::recorder::options;
use crate::{RecordedMessage, Recording, RecordingError};

/// The bytes of a complete file with the messages that can be decoded. If something is lost, metadata `recovered` says what,
/// and gives the digest of the last state that was kept. All metadata of the recording is kept.
///
/// # Errors
/// If the MCAP writer fails.
pub fn recover(recording: &Recording<'_>) -> Result<Vec<u8>, RecordingError> {
    let out = OutputBuffer::default();
    let mut writer =
        options().profile(recording.profile.clone()).create(mcap::write::NoSeek::new(out.clone()))?;
    let write_metadata = |writer: &mut mcap::Writer<_>, name: &str, entries: &BTreeMap<String, String>| {
        writer.write_metadata(&Metadata { name: name.into(), metadata: entries.clone() })
    };
    let (ends, beginnings): (Vec<_>, Vec<_>) =
        recording.metadata_records().iter().partition(|(name, _)| name == "end");
    for (name, entries) in beginnings {
        write_metadata(&mut writer, name, entries)?;
    }
    let mut definitions = recording.definitions().clone();
    // Number of each channel in the new file, by that in the recording.
    let mut channels = BTreeMap::new();
    for (id, channel) in definitions.channels() {
        channels.insert(*id, add_channel(&mut writer, &definitions, channel)?);
    }
    for section in recording.sections() {
        for record in records(section) {
            if record.kind != kind::MESSAGE {
                let replaced = definitions.replace(&record);
                if let Some((id, channel)) =
                    replaced.and_then(|id| Some((id, definitions.channels().get(&id)?)))
                {
                    channels.insert(id, add_channel(&mut writer, &definitions, channel)?);
                }
                continue;
            }
            let Some(entry) = definitions.entry(&record).filter(|entry| entry.undecodable().is_none()) else {
                continue;
            };
            let channel =
                layout::message(record.body).and_then(|(channel, ..)| channels.get(&channel).copied());
            let Some(channel_id) = channel else { continue };
            let header = MessageHeader {
                channel_id,
                sequence: entry.sequence,
                log_time: entry.logged.0,
                publish_time: entry.published.0,
            };
            writer.write_to_known_channel(&header, entry.data)?;
        }
        writer.flush()?;
    }
    for (name, entries) in ends {
        write_metadata(&mut writer, name, entries)?;
    }
    if let Some(notes) = notes(recording) {
        write_metadata(&mut writer, "recovered", &notes)?;
    }
    writer.finish()?;
    Ok(out.take())
}

fn add_channel<W: std::io::Write + std::io::Seek>(
    writer: &mut mcap::Writer<W>,
    definitions: &Definitions,
    channel: &ChannelDefinition,
) -> Result<u16, RecordingError> {
    let schema = match definitions.schema_of(channel) {
        Some(schema) => writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
        None => 0,
    };
    Ok(writer.add_channel(schema, &channel.topic, &channel.encoding, &channel.metadata)?)
}

/// What was lost; `None` if nothing was.
fn notes(recording: &Recording<'_>) -> Option<BTreeMap<String, String>> {
    let undecodable = recording.undecodable();
    if recording.is_whole() && undecodable.is_empty() {
        return None;
    }
    let mut notes = BTreeMap::from([("lost_bytes".to_owned(), recording.lost_bytes().to_string())]);
    if let Some(fault) = &recording.fault {
        notes.insert("fault".into(), fault.clone());
    }
    if recording.without_channel() > 0 {
        notes.insert("without_channel".into(), recording.without_channel().to_string());
    }
    if let Some(first) = undecodable.first {
        notes.insert("undecodable".into(), undecodable.messages.to_string());
        notes.insert("first_undecodable".into(), first);
    }
    let states = recording.messages().filter_map(|message| match message {
        Ok((_, RecordedMessage::State(state))) => Some(state),
        _ => None,
    });
    if let Some(state) = states.last() {
        notes.insert("digest".into(), state.digest.to_string());
        notes.insert("decision".into(), state.decision.to_string());
    }
    Some(notes)
}
