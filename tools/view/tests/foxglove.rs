//! A viewer of `hopper monitor --foxglove`.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../tests/harness/mod.rs"]
mod harness;

use std::collections::BTreeMap;
use std::net::TcpStream;

use harness::{Mission, Process};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Where a monitor serves viewers.
fn address_of(monitor: &Process) -> String {
    monitor.await_log("viewers connect to ws://");
    let log = monitor.log();
    log.split("viewers connect to ").nth(1).unwrap().split_whitespace().next().unwrap().to_owned()
}

/// A client of Foxglove's WebSocket protocol, version 1.
struct Viewer {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    /// Ids by topic, as advertised so far, with the names of their schemas.
    channels: BTreeMap<String, (u64, String)>,
    name: Option<String>,
    /// Messages of each subscription.
    messages: BTreeMap<u32, u64>,
}

impl Viewer {
    fn of(monitor: &Process) -> Self {
        Self::with(&address_of(monitor), &[("Sec-WebSocket-Protocol", "foxglove.sdk.v1")]).unwrap()
    }

    /// Connects with these headers; the status if it is refused.
    fn with(address: &str, headers: &[(&'static str, &str)]) -> Result<Self, u16> {
        let mut request = address.into_client_request().unwrap();
        for (name, value) in headers {
            request.headers_mut().insert(*name, value.parse().unwrap());
        }
        let socket = match tungstenite::connect(request) {
            Ok((socket, _)) => socket,
            Err(tungstenite::Error::Http(response)) => return Err(response.status().as_u16()),
            Err(error) => panic!("{error}"),
        };
        let MaybeTlsStream::Plain(stream) = socket.get_ref() else { panic!("not TLS") };
        stream.set_read_timeout(Some(harness::PATIENCE)).unwrap();
        Ok(Self { socket, channels: BTreeMap::new(), name: None, messages: BTreeMap::new() })
    }

    /// Reads until `claim` is true.
    fn read_until(&mut self, claim: impl Fn(&Self) -> bool) {
        while !claim(self) {
            match self.socket.read().unwrap() {
                Message::Text(text) => {
                    let told: Value = serde_json::from_str(&text).unwrap();
                    self.name = told["name"].as_str().map(str::to_owned).or(self.name.take());
                    for channel in told["channels"].as_array().into_iter().flatten() {
                        let (topic, schema) =
                            (channel["topic"].as_str().unwrap(), channel["schemaName"].as_str().unwrap());
                        let id = channel["id"].as_u64().unwrap();
                        self.channels.insert(topic.into(), (id, schema.into()));
                    }
                }
                // Opcode 1, subscription, time, payload.
                Message::Binary(bytes) if bytes[0] == 1 => {
                    let subscription = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
                    assert!(bytes.len() > 13, "a payload");
                    *self.messages.entry(subscription).or_default() += 1;
                }
                _ => {}
            }
        }
    }

    fn subscribe(&mut self, subscription: u32, topic: &str) {
        let id = self.channels[topic].0;
        let ask = json!({"op": "subscribe", "subscriptions": [{"id": subscription, "channelId": id}]});
        self.socket.send(Message::text(ask.to_string())).unwrap();
    }

    fn has(&self, subscription: u32, count: u64) -> bool {
        self.messages.get(&subscription).is_some_and(|messages| *messages >= count)
    }
}

/// P-FOXGLOVE: `hopper monitor --foxglove` advertises every channel of a recording and sends its
/// messages. A viewer that connects late gets the newest of each channel, and a viewer that does
/// not read delays no hop.
#[test]
fn a_viewer_is_told_the_channels_and_gets_messages() {
    let mission = Mission::new("foxglove");
    let slow = mission.start_slow_sim("3");
    let mut monitor = mission.start("monitor", &["--foxglove", "127.0.0.1:0"]);
    let _peers = ["perception", "planner"].map(|role| mission.start(role, &[]));
    let mut viewer = Viewer::of(&monitor);
    let all: Vec<_> = recording::Channel::ALL.map(|channel| channel.name()).into();
    viewer.read_until(|viewer| all.iter().all(|topic| viewer.channels.contains_key(topic)));
    assert_eq!(viewer.name.as_deref(), Some(format!("hopper {}", mission.name).as_str()));
    assert_eq!(viewer.channels["view/map"].1, "foxglove.PointCloud");
    assert_eq!(viewer.channels["hop/state"].1, "hopper.State");
    mission.await_decisions(2);

    // What was published before, as the brief, is there for whoever comes now.
    let mut late = Viewer::of(&monitor);
    late.read_until(|viewer| viewer.channels.contains_key("view/map"));
    for (subscription, topic) in (0..).zip(["hop/brief", "view/map", "view/robots"]) {
        late.subscribe(subscription, topic);
    }
    late.read_until(|viewer| (0..3).all(|subscription| viewer.has(subscription, 1)));

    // It subscribes to everything that grows and reads no more.
    for (subscription, topic) in (0..).zip(all.iter().filter(|topic| !topic.ends_with("policy"))) {
        viewer.subscribe(subscription, topic);
    }
    late.subscribe(3, "hop/state");
    late.subscribe(4, "view/plan");
    late.read_until(|viewer| viewer.has(3, 2) && viewer.has(4, 1));
    let sim = mission.hurry(slow, "3");
    assert_eq!(sim.json()["digest"], harness::lockstep(&["--seed", "3"])["digest"]);
    drop(late);
    assert_eq!(monitor.code(), 0, "{}", monitor.log());
}

/// P-FOXGLOVE-LICHTBLICK: Viewers that call the protocol by its older name, as Lichtblick does, are
/// served.
/// P-FOXGLOVE-GATE. A page of another server is refused unless it is named, and the log says how;
/// many silent sockets keep no viewer out.
#[test]
fn pages_and_silent_sockets_get_nothing_and_older_viewers_are_served() {
    let mission = Mission::new("foxglove-gate");
    let _slow = mission.start_slow_sim("3");
    let words = ["--foxglove", "127.0.0.1:0", "--foxglove-origin", "https://viewer.example"];
    let monitor = mission.start("monitor", &words);
    let address = address_of(&monitor);
    let older = ("Sec-WebSocket-Protocol", "foxglove.websocket.v1");
    let socket = address.strip_prefix("ws://").unwrap().trim_end_matches('/').to_owned();
    let silent: Vec<TcpStream> = (0..150).map(|_| TcpStream::connect(&socket).unwrap()).collect();
    for (headers, status) in [
        (vec![older, ("Origin", "http://evil.example")], 403),
        (vec![older, ("Origin", "http://evil.example")], 403),
        (vec![older, ("Origin", "null")], 403),
        (vec![older, ("Host", "evil.example:8765")], 421),
        (vec![("Sec-WebSocket-Protocol", "graphql-ws")], 400),
    ] {
        assert_eq!(Viewer::with(&address, &headers).err(), Some(status), "{headers:?}");
    }
    let log = monitor.log();
    assert_eq!(log.matches("--foxglove-origin http://evil.example").count(), 1, "{log}");
    for origin in [None, Some("https://viewer.example"), Some("http://localhost:8080")] {
        let headers: Vec<_> = std::iter::once(older).chain(origin.map(|origin| ("Origin", origin))).collect();
        let mut viewer = Viewer::with(&address, &headers).unwrap();
        viewer.read_until(|viewer| viewer.name.is_some() && viewer.channels.contains_key("view/map"));
        viewer.subscribe(1, "hop/heartbeat");
        viewer.read_until(|viewer| viewer.has(1, 1));
    }
    drop(silent);
}

/// An address that is taken is a usage error before anything flies.
#[test]
fn an_address_that_is_taken_is_a_usage_error() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let mission = Mission::new("foxglove-taken");
    let mut monitor = mission.start("monitor", &["--foxglove", &address]);
    assert_eq!(monitor.code(), 2, "{}", monitor.log());
    assert!(monitor.log().contains("--foxglove cannot listen on"), "{}", monitor.log());
}
