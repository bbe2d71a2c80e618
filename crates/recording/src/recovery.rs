//! Completes a cut recording: everything up to the last valid record, with the missing index.

use std::collections::BTreeMap;

use mcap::records::{MessageHeader, Metadata};

use crate::layout::{self, kind};
use crate::output_buffer::OutputBuffer;
use crate::reader::records;
use crate::recorder::options;
use crate::{RecordedMessage, Recording, RecordingError};

/// The bytes of a complete file. If the recording was cut, metadata `recovered` says what was lost and gives the
/// digest of the last state that was kept.
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
    for (name, entries) in recording.metadata.iter().filter(|(name, _)| *name != "end") {
        write_metadata(&mut writer, name, entries)?;
    }
    let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
    for section in recording.sections() {
        for record in records(section) {
            match record.kind {
                kind::SCHEMA => {
                    let Some((id, name, encoding, data)) = layout::schema(record.body) else { continue };
                    schemas.insert(id, writer.add_schema(&name, &encoding, data)?);
                }
                kind::CHANNEL => {
                    let Some((id, schema, topic, encoding, metadata)) = layout::channel(record.body) else {
                        continue;
                    };
                    let schema = schemas.get(&schema).copied().unwrap_or(0);
                    channels.insert(id, writer.add_channel(schema, &topic, &encoding, &metadata)?);
                }
                kind::MESSAGE => {
                    let known = layout::message(record.body);
                    let known = known.and_then(|message| Some((message, *channels.get(&message.0)?)));
                    let Some(((_, sequence, log_time, publish_time, data), channel_id)) = known else {
                        continue;
                    };
                    let header = MessageHeader { channel_id, sequence, log_time, publish_time };
                    writer.write_to_known_channel(&header, data)?;
                }
                _ => {}
            }
        }
        writer.flush()?;
    }
    if let Some(entries) = recording.metadata.get("end") {
        write_metadata(&mut writer, "end", entries)?;
    }
    if let Some(fault) = &recording.fault {
        let mut notes = BTreeMap::from([
            ("fault".to_owned(), fault.clone()),
            ("lost_bytes".to_owned(), recording.lost_bytes().to_string()),
        ]);
        let last = recording.messages().filter_map(|message| match message {
            Ok((_, RecordedMessage::State(state))) => Some(state),
            _ => None,
        });
        if let Some(state) = last.last() {
            notes.insert("digest".into(), state.digest.to_string());
            notes.insert("decision".into(), state.decision.to_string());
        }
        write_metadata(&mut writer, "recovered", &notes)?;
    }
    writer.finish()?;
    Ok(out.take())
}
