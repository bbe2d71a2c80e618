//! The channels of a live connection, with the newest message of each for viewers that come late.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use foxglove::websocket::{ChannelView, Client, ServerListener};
use foxglove::{ChannelBuilder, Context, PartialMetadata, RawChannel, Schema};
use recording::{Channel, EncodedMessage, Topic};

/// Channels by topic; those of JSON messages, and of the commands of robots but the first, are added with their first message.
pub(crate) struct Channels {
    context: Arc<Context>,
    open: Mutex<Open>,
}

#[derive(Default)]
struct Open {
    channels: BTreeMap<String, OpenChannel>,
    /// How many subscriptions want policies.
    policies: usize,
}

struct OpenChannel {
    channel: Arc<RawChannel>,
    newest: Option<EncodedMessage>,
}

impl Channels {
    /// Advertises every channel that has a schema.
    pub fn new(context: &Arc<Context>) -> Self {
        let channels = Self { context: Arc::clone(context), open: Mutex::default() };
        for channel in Channel::ALL {
            channels.add(&mut channels.lock(), &Topic::Known(channel));
        }
        channels
    }

    /// Sends a message to whoever has subscribed.
    pub fn publish(&self, message: EncodedMessage) {
        let mut open = self.lock();
        let name = message.topic.name();
        if !matches!(message.topic, Topic::Known(_)) && !open.channels.contains_key(&name) {
            self.add(&mut open, &message.topic);
        }
        if let Some(OpenChannel { channel, newest }) = open.channels.get_mut(&name) {
            channel.log_with_meta(&message.data, moment(&message));
            *newest = Some(message);
        }
    }

    /// Whether some viewer looks at policies, which cost a planner time.
    pub fn wants_policies(&self) -> bool {
        self.lock().policies > 0
    }

    fn add(&self, open: &mut Open, topic: &Topic) {
        let topic_schema = topic.schema();
        let schema =
            topic_schema.map(|channel| Schema::new(channel.schema(), "protobuf", channel.descriptors()));
        let (topic, encoding) = (topic.name(), if schema.is_some() { "protobuf" } else { "json" });
        let builder =
            ChannelBuilder::new(&topic).context(&self.context).message_encoding(encoding).schema(schema);
        match builder.build_raw() {
            Ok(channel) => _ = open.channels.insert(topic, OpenChannel { channel, newest: None }),
            Err(error) => tracing::warn!("{topic} is not served to viewers: {error}"),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn moment(message: &EncodedMessage) -> PartialMetadata {
    PartialMetadata { log_time: Some(message.logged.0) }
}

/// Topics that policies are made for.
fn shows_policies(topic: &str) -> bool {
    topic == Channel::Policy.name() || topic == Channel::ViewPlan.name()
}

impl ServerListener for Channels {
    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        let mut open = self.lock();
        open.policies += usize::from(shows_policies(channel.topic()));
        if let Some(OpenChannel { channel, newest: Some(newest) }) = open.channels.get(channel.topic()) {
            channel.log_with_meta_to_sink(&newest.data, moment(newest), client.sink_id());
        }
    }

    fn on_unsubscribe(&self, _client: Client, channel: ChannelView) {
        let mut open = self.lock();
        open.policies = open.policies.saturating_sub(usize::from(shows_policies(channel.topic())));
    }
}
