//! Messages that have no schema of ours: recorded as JSON, so that a new message is in recordings before it has one.

use contract::Message;

use crate::Channel;
use crate::channel::ROBOT;

/// A public message without a [`Channel`], encoded as JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JsonMessage {
    /// Name of its service.
    pub topic: String,
    /// Its fields by name, as `hopper topic echo --format json --full` prints them.
    pub json: Vec<u8>,
}

impl JsonMessage {
    /// The encoded message; `None` if it has a channel with a schema, or a value that JSON cannot hold.
    #[must_use]
    pub fn of<M: Message>(message: &M) -> Option<Self> {
        let topic = Self::topic::<M>()?;
        Some(Self { topic, json: serde_json::to_vec(message).ok()? })
    }

    /// The topic of the messages of type `M`; `None` if they have a channel with a schema.
    #[must_use]
    pub fn topic<M: Message>() -> Option<String> {
        let topic = M::SERVICE.name_of(ROBOT);
        Channel::of(&topic).is_none().then_some(topic)
    }
}
