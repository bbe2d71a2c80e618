//! Keeps the schemas and channels that a file defines, wherever in the file they stand.
//!
//! A message normally follows its channel. Programs that reorder a file do not keep that: its chunks may stand backwards,
//! and its channels only in the summary. Such a message belongs to the first definition of its channel in the file.

use std::collections::BTreeMap;

use contract::MonotonicNs;

use crate::layout::{self, Framed, kind};
use crate::{Channel, Entry};

/// A schema record without its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Schema {
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// A channel record without its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ChannelDefinition {
    /// Number of its schema; 0 if it has none.
    pub schema: u16,
    pub topic: String,
    pub encoding: String,
    pub metadata: BTreeMap<String, String>,
    /// The channel, if it is one of Hopper's with the expected schema.
    pub known: Option<Channel>,
}

/// Schemas and channels by their numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Definitions {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, ChannelDefinition>,
}

impl Definitions {
    /// Takes a schema or a channel whose number is not taken yet; other records change nothing.
    pub fn add(&mut self, record: &Framed<'_>) {
        match record.kind {
            kind::SCHEMA => {
                if let Some((id, schema)) = schema(record) {
                    self.schemas.entry(id).or_insert(schema);
                }
            }
            kind::CHANNEL => {
                if let Some((id, channel)) = channel(record) {
                    self.channels.entry(id).or_insert(channel);
                }
            }
            _ => {}
        }
    }

    /// Finds out which channels are Hopper's. A channel may stand before its schema, so this comes after the last
    /// [`Definitions::add`].
    pub fn resolve(&mut self) {
        for channel in self.channels.values_mut() {
            channel.known = known(&self.schemas, channel);
        }
    }

    /// Takes a schema or a channel that is in force from here on; returns the number of a channel.
    pub fn replace(&mut self, record: &Framed<'_>) -> Option<u16> {
        match record.kind {
            kind::SCHEMA => {
                let (id, schema) = schema(record)?;
                self.schemas.insert(id, schema);
                None
            }
            kind::CHANNEL => {
                let (id, mut channel) = channel(record)?;
                channel.known = known(&self.schemas, &channel);
                self.channels.insert(id, channel);
                Some(id)
            }
            _ => None,
        }
    }

    /// All channels by their numbers.
    pub fn channels(&self) -> &BTreeMap<u16, ChannelDefinition> {
        &self.channels
    }

    /// The schema of a channel; `None` if it has none, or the file does not define it.
    pub fn schema_of(&self, channel: &ChannelDefinition) -> Option<&Schema> {
        schema_of(&self.schemas, channel)
    }

    /// The message in a message record, with number 0; `None` if its channel is not defined.
    pub fn entry<'a>(&self, record: &Framed<'a>) -> Option<Entry<'a>> {
        let (channel, sequence, logged, published, data) = layout::message(record.body)?;
        let channel = self.channels.get(&channel)?;
        Some(Entry {
            number: 0,
            topic: channel.topic.clone(),
            known: channel.known,
            logged: MonotonicNs(logged),
            published: MonotonicNs(published),
            sequence,
            data,
        })
    }
}

fn schema(record: &Framed<'_>) -> Option<(u16, Schema)> {
    let (id, name, encoding, data) = layout::schema(record.body)?;
    Some((id, Schema { name, encoding, data: data.to_vec() }))
}

fn channel(record: &Framed<'_>) -> Option<(u16, ChannelDefinition)> {
    let (id, schema, topic, encoding, metadata) = layout::channel(record.body)?;
    Some((id, ChannelDefinition { schema, topic, encoding, metadata, known: None }))
}

fn schema_of<'a>(schemas: &'a BTreeMap<u16, Schema>, channel: &ChannelDefinition) -> Option<&'a Schema> {
    if channel.schema == 0 { None } else { schemas.get(&channel.schema) }
}

fn known(schemas: &BTreeMap<u16, Schema>, channel: &ChannelDefinition) -> Option<Channel> {
    let schema = schema_of(schemas, channel)?;
    let known = Channel::of(&channel.topic)?;
    if channel.encoding == "protobuf" && schema.name == known.schema() { Some(known) } else { None }
}
