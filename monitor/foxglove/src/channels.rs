//! The channels of a live connection, the newest message of each for viewers that come late, and what waits for each viewer.

use std::collections::{BTreeMap, VecDeque};
use std::io::Write as _;
use std::net::TcpStream;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use monitor::web::Rejection;
use recording::{Channel, EncodedMessage, Topic};
use serde_json::Value;

use crate::protocol::{self, Request, Subscription};

/// Most viewers at once, those that connect included.
pub(crate) const VIEWERS_MAX: usize = 16;

/// Most messages, and most bytes of them, that wait for a viewer: the oldest are dropped.
const BACKLOG_MAX: usize = 1024;
const BACKLOG_BYTES_MAX: usize = 32 << 20;

/// Most replies that wait for a viewer, which asks more than it reads.
const REPLIES_MAX: usize = 256;

/// Channels by topic, and the viewers. The work loop adds messages, the server's thread sends them.
pub(crate) struct Channels {
    /// What a viewer is told first.
    greeting: String,
    state: Mutex<State>,
    /// Wakes the server's thread.
    wake: UnixStream,
}

#[derive(Default)]
struct State {
    channels: Vec<OpenChannel>,
    /// Places of channels by topic.
    places: BTreeMap<String, usize>,
    /// In the order in which they came, by number.
    viewers: BTreeMap<u64, Outbox>,
    /// Number of viewers so far.
    count: u64,
    /// Sockets of viewers whom the server's thread has not taken yet.
    arrivals: Vec<Arrival>,
}

/// A channel. Those of JSON messages, and of the commands of robots but the first, are added with their first message.
struct OpenChannel {
    topic: String,
    advertised: Value,
    newest: Option<Arc<EncodedMessage>>,
}

/// What waits for a viewer.
#[derive(Default)]
struct Outbox {
    subscriptions: BTreeMap<u32, usize>,
    replies: VecDeque<String>,
    messages: VecDeque<(u32, Arc<EncodedMessage>)>,
    bytes: usize,
    /// Its connection is to be closed: it makes room, or asks more than it reads.
    dismissed: bool,
}

/// A viewer that has connected.
pub(crate) struct Arrival {
    /// Number of the viewer.
    pub viewer: u64,
    /// Its socket, which does not block.
    pub stream: TcpStream,
    /// What came after the handshake.
    pub rest: Vec<u8>,
}

/// The place of a viewer that connects.
pub(crate) struct Place {
    channels: Arc<Channels>,
    viewer: u64,
    arrived: bool,
}

/// What to send to a viewer next.
pub(crate) enum Next {
    Text(String),
    Message(u32, Arc<EncodedMessage>),
    Nothing,
}

impl Channels {
    /// Advertises every channel that has a schema. What becomes readable when there is something to do is returned beside.
    pub fn new(name: &str) -> std::io::Result<(Arc<Self>, UnixStream)> {
        let (wake, woken) = UnixStream::pair()?;
        wake.set_nonblocking(true)?;
        woken.set_nonblocking(true)?;
        let session = format!("{}-{}", std::process::id(), node::Node::now().0);
        let greeting = protocol::server_info(&format!("hopper {name}"), &session);
        let channels = Self { greeting, state: Mutex::default(), wake };
        let mut state = channels.lock();
        Channel::ALL.into_iter().for_each(|channel| _ = state.channel(&Topic::Known(channel)));
        drop(state);
        Ok((Arc::new(channels), woken))
    }

    /// Sends a message to whoever has subscribed.
    pub fn publish(&self, message: EncodedMessage) {
        let mut state = self.lock();
        let place = state.channel(&message.topic);
        let message = Arc::new(message);
        state.channels[place].newest = Some(Arc::clone(&message));
        let mut any = false;
        for outbox in state.viewers.values_mut() {
            for (&id, _) in outbox.subscriptions.iter().filter(|(_, channel)| **channel == place) {
                outbox.bytes += message.data.len();
                outbox.messages.push_back((id, Arc::clone(&message)));
                any = true;
            }
            outbox.shorten();
        }
        drop(state);
        if any {
            self.wake();
        }
    }

    /// Whether some viewer looks at policies, which cost a planner time.
    pub fn wants_policies(&self) -> bool {
        let state = self.lock();
        let shows = |place: &usize| shows_policies(&state.channels[*place].topic);
        state.viewers.values().any(|outbox| outbox.subscriptions.values().any(shows))
    }

    /// Number of viewers.
    #[cfg(test)]
    pub fn viewers(&self) -> usize {
        self.lock().viewers.len()
    }

    /// A place for a viewer that connects. If all are taken, the first viewer that has subscribed to nothing makes room.
    pub fn place(self: &Arc<Self>) -> Result<Place, Rejection> {
        let mut state = self.lock();
        let taken = state.viewers.values().filter(|outbox| !outbox.dismissed).count();
        if taken >= VIEWERS_MAX {
            let idle = state.viewers.values_mut().find(|outbox| outbox.is_idle());
            let none = || Rejection::new(503, format!("{VIEWERS_MAX} viewers are connected already"));
            idle.ok_or_else(none)?.dismissed = true;
            self.wake();
        }
        let viewer = state.count;
        state.count += 1;
        let channels: Vec<Value> = state.channels.iter().map(|channel| channel.advertised.clone()).collect();
        let replies = [self.greeting.clone(), protocol::advertise(&channels)].into();
        state.viewers.insert(viewer, Outbox { replies, ..Outbox::default() });
        Ok(Place { channels: Arc::clone(self), viewer, arrived: false })
    }

    /// The viewers that have connected since the last call.
    pub fn arrivals(&self) -> Vec<Arrival> {
        std::mem::take(&mut self.lock().arrivals)
    }

    /// Takes what waits for a viewer first.
    pub fn next(&self, viewer: u64) -> Next {
        let mut state = self.lock();
        let Some(outbox) = state.viewers.get_mut(&viewer) else { return Next::Nothing };
        if let Some(reply) = outbox.replies.pop_front() {
            return Next::Text(reply);
        }
        match outbox.messages.pop_front() {
            Some((id, message)) => {
                outbox.bytes -= message.data.len();
                Next::Message(id, message)
            }
            None => Next::Nothing,
        }
    }

    /// Whether a viewer's connection is to be closed.
    pub fn is_dismissed(&self, viewer: u64) -> bool {
        self.lock().viewers.get(&viewer).is_none_or(|outbox| outbox.dismissed)
    }

    /// Does what a viewer asks for.
    pub fn request(&self, viewer: u64, text: &str) {
        let mut state = self.lock();
        let State { channels, viewers, .. } = &mut *state;
        let Some(outbox) = viewers.get_mut(&viewer) else { return };
        match serde_json::from_str(text) {
            Ok(Request::Subscribe { subscriptions }) => {
                subscriptions.iter().for_each(|wish| outbox.subscribe(wish, channels));
            }
            Ok(Request::Unsubscribe { subscription_ids }) => {
                subscription_ids.iter().for_each(|id| _ = outbox.subscriptions.remove(id));
            }
            Ok(Request::Other) => {}
            Err(error) => {
                outbox.replies.push_back(protocol::error(&format!("a request was not read: {error}")))
            }
        }
        outbox.shorten();
    }

    /// Forgets a viewer that is gone.
    pub fn leave(&self, viewer: u64) {
        self.lock().viewers.remove(&viewer);
    }

    /// Wakes the server's thread.
    pub fn wake(&self) {
        // A full pipe wakes it too.
        let _ = (&self.wake).write(&[1]);
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// The place of a topic's channel, which is made if there is none.
    fn channel(&mut self, topic: &Topic) -> usize {
        let name = topic.name();
        if let Some(&place) = self.places.get(&name) {
            return place;
        }
        let place = self.channels.len();
        let advertised = protocol::channel(id_of(place), topic);
        let told = protocol::advertise(std::slice::from_ref(&advertised));
        for outbox in self.viewers.values_mut() {
            outbox.replies.push_back(told.clone());
            outbox.shorten();
        }
        self.channels.push(OpenChannel { topic: name.clone(), advertised, newest: None });
        self.places.insert(name, place);
        place
    }
}

impl Outbox {
    /// Adds a subscription, and what its channel had last. A channel has at most one.
    fn subscribe(&mut self, wish: &Subscription, channels: &[OpenChannel]) {
        let Subscription { id, channel_id } = *wish;
        let refusal = match (0..channels.len()).find(|&place| id_of(place) == channel_id) {
            None => "there is no such channel",
            Some(place) if self.subscriptions.values().any(|taken| *taken == place) => {
                "it has a subscription already"
            }
            Some(_) if self.subscriptions.contains_key(&id) => "the subscription's number is taken",
            Some(place) => {
                self.subscriptions.insert(id, place);
                if let Some(newest) = &channels[place].newest {
                    self.bytes += newest.data.len();
                    self.messages.push_back((id, Arc::clone(newest)));
                }
                return;
            }
        };
        let why = format!("subscription {id} of channel {channel_id}: {refusal}");
        self.replies.push_back(protocol::error(&why));
    }

    /// Drops the oldest messages beyond what may wait, and gives up a viewer that does not read what it asked for.
    fn shorten(&mut self) {
        while self.messages.len() > BACKLOG_MAX || self.bytes > BACKLOG_BYTES_MAX && self.messages.len() > 1 {
            if let Some((_, message)) = self.messages.pop_front() {
                self.bytes -= message.data.len();
            }
        }
        self.dismissed |= self.replies.len() > REPLIES_MAX;
    }

    fn is_idle(&self) -> bool {
        self.subscriptions.is_empty() && !self.dismissed
    }
}

impl Place {
    /// Gives the viewer's socket to the server's thread.
    pub fn arrive(mut self, stream: TcpStream, rest: Vec<u8>) {
        self.arrived = true;
        self.channels.lock().arrivals.push(Arrival { viewer: self.viewer, stream, rest });
        self.channels.wake();
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if !self.arrived {
            self.channels.leave(self.viewer);
        }
    }
}

/// Number by which viewers name a channel.
fn id_of(place: usize) -> u64 {
    place as u64 + 1
}

/// Topics that policies are made for.
fn shows_policies(topic: &str) -> bool {
    topic == Channel::Policy.name() || topic == Channel::ViewPlan.name()
}

#[cfg(test)]
mod tests {
    use contract::MonotonicNs;

    use super::*;

    fn message(channel: Channel, size: usize) -> EncodedMessage {
        let (topic, now) = (Topic::Known(channel), MonotonicNs(1));
        EncodedMessage { topic, data: vec![0; size], published: now, logged: now }
    }

    fn subscribe(channels: &Channels, place: &Place, id: u32, channel: u64) {
        let text = format!(r#"{{"op":"subscribe","subscriptions":[{{"id":{id},"channelId":{channel}}}]}}"#);
        channels.request(place.viewer, &text);
    }

    /// What waits for a viewer: texts, and sizes of messages by subscription.
    fn drained(channels: &Channels, place: &Place) -> (Vec<String>, Vec<(u32, usize)>) {
        let (mut texts, mut messages) = (Vec::new(), Vec::new());
        loop {
            match channels.next(place.viewer) {
                Next::Text(text) => texts.push(text),
                Next::Message(id, message) => messages.push((id, message.data.len())),
                Next::Nothing => return (texts, messages),
            }
        }
    }

    /// P-FOXGLOVE-BOUNDED: The queue of a viewer is bounded and keeps the newest messages; a viewer
    /// without a subscription makes room for another.
    #[test]
    fn what_waits_for_a_viewer_is_bounded_and_is_the_newest() {
        let (channels, _woken) = Channels::new("test").unwrap();
        let place = channels.place().unwrap();
        subscribe(&channels, &place, 7, 1);
        for size in 0..2000 {
            channels.publish(message(Channel::ALL[0], size));
        }
        let (texts, messages) = drained(&channels, &place);
        assert_eq!((texts.len(), messages.len()), (2, BACKLOG_MAX));
        assert_eq!(messages.last(), Some(&(7, 1999)));
        for _ in 0..5 {
            channels.publish(message(Channel::ALL[0], BACKLOG_BYTES_MAX / 3));
        }
        assert_eq!(drained(&channels, &place).1.len(), 3);
        channels.publish(message(Channel::ALL[0], 2 * BACKLOG_BYTES_MAX));
        assert_eq!(drained(&channels, &place).1.len(), 1, "one that is larger than all waits alone");
        for _ in 0..=REPLIES_MAX {
            channels.request(place.viewer, "nonsense");
        }
        assert!(channels.is_dismissed(place.viewer), "it asks and does not read");
    }

    /// P-FOXGLOVE-BOUNDED. Viewers without a subscription make room for others.
    #[test]
    fn a_viewer_without_a_subscription_makes_room() {
        let (channels, _woken) = Channels::new("test").unwrap();
        let places: Vec<Place> = (0..VIEWERS_MAX).map(|_| channels.place().unwrap()).collect();
        subscribe(&channels, &places[0], 1, 1);
        let last = channels.place().unwrap();
        assert!(channels.is_dismissed(places[1].viewer), "the first that looks at nothing");
        assert!(!channels.is_dismissed(places[0].viewer) && !channels.is_dismissed(places[2].viewer));
        for place in places[2..].iter().chain([&last]) {
            subscribe(&channels, place, 1, 1);
        }
        assert_eq!(channels.place().map(drop).unwrap_err().0, 503, "all look at something");
    }

    #[test]
    fn a_channel_has_one_subscription_and_who_is_late_gets_its_newest_message() {
        let (channels, _woken) = Channels::new("test").unwrap();
        channels.publish(message(Channel::ALL[0], 5));
        let place = channels.place().unwrap();
        for (id, channel) in [(1, 1), (1, 2), (2, 1), (3, 999)] {
            subscribe(&channels, &place, id, channel);
        }
        let (texts, messages) = drained(&channels, &place);
        assert_eq!((messages, texts.len()), (vec![(1, 5)], 5), "{texts:?}");
        channels.request(place.viewer, r#"{"op":"unsubscribe","subscriptionIds":[1,9]}"#);
        channels.publish(message(Channel::ALL[0], 6));
        assert!(drained(&channels, &place).1.is_empty());
    }
}
