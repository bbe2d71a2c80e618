//! The messages of Foxglove's WebSocket protocol, version 1, as far as a server needs them that only publishes.
//!
//! [The specification](https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md) calls it `foxglove.websocket.v1`; newer
//! viewers call the same messages `foxglove.sdk.v1`.

use contract::MonotonicNs;
use data_encoding::BASE64;
use recording::Topic;
use serde::Deserialize;
use serde_json::{Value, json};

/// Names of the protocol in the WebSocket handshake, the preferred one first.
pub(crate) const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// Opcode of a binary message with data.
const MESSAGE_DATA: u8 = 1;

/// What a viewer asks for. Everything else is skipped: the server announces no capability.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(crate) enum Request {
    /// Messages of channels.
    Subscribe {
        /// One for each channel.
        subscriptions: Vec<Subscription>,
    },
    /// No more of them.
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        /// Numbers that the viewer gave.
        subscription_ids: Vec<u32>,
    },
    #[serde(other)]
    Other,
}

/// A viewer's wish for the messages of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Subscription {
    /// Number that the viewer gives it.
    pub id: u32,
    /// Number of the channel.
    pub channel_id: u64,
}

/// The first message to a viewer.
pub(crate) fn server_info(name: &str, session: &str) -> String {
    json!({"op": "serverInfo", "name": name, "capabilities": [], "metadata": {}, "sessionId": session})
        .to_string()
}

/// What a viewer is told of a channel.
pub(crate) fn channel(id: u64, topic: &Topic) -> Value {
    match topic.schema() {
        Some(channel) => json!({
            "id": id,
            "topic": topic.name(),
            "encoding": "protobuf",
            "schemaName": channel.schema(),
            "schemaEncoding": "protobuf",
            "schema": BASE64.encode(channel.descriptors()),
        }),
        None => json!({"id": id, "topic": topic.name(), "encoding": "json", "schemaName": "", "schema": ""}),
    }
}

/// Tells a viewer of channels.
pub(crate) fn advertise(channels: &[Value]) -> String {
    json!({"op": "advertise", "channels": channels}).to_string()
}

/// Why a request of a viewer is not met.
pub(crate) fn error(message: &str) -> String {
    json!({"op": "status", "level": 2, "message": message}).to_string()
}

/// A message of a channel for the subscription `id`.
pub(crate) fn message_data(id: u32, logged: MonotonicNs, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(13 + data.len());
    bytes.push(MESSAGE_DATA);
    bytes.extend_from_slice(&id.to_le_bytes());
    bytes.extend_from_slice(&logged.0.to_le_bytes());
    bytes.extend_from_slice(data);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_and_what_is_not_known_is_skipped() {
        let read = |text: &str| serde_json::from_str::<Request>(text);
        let subscriptions = vec![Subscription { id: 3, channel_id: 9 }];
        assert_eq!(
            read(r#"{"op":"subscribe","subscriptions":[{"id":3,"channelId":9}]}"#).unwrap(),
            Request::Subscribe { subscriptions }
        );
        assert_eq!(
            read(r#"{"op":"unsubscribe","subscriptionIds":[3]}"#).unwrap(),
            Request::Unsubscribe { subscription_ids: vec![3] }
        );
        assert_eq!(read(r#"{"op":"getParameters","id":"x","parameterNames":[]}"#).unwrap(), Request::Other);
        for text in
            ["", "{}", "[]", r#"{"op":"subscribe"}"#, r#"{"op":"subscribe","subscriptions":[{"id":-1}]}"#]
        {
            assert!(read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_message_has_opcode_subscription_time_and_payload() {
        let bytes = message_data(0x0102, MonotonicNs(3), b"ab");
        assert_eq!(bytes, [&[1, 2, 1, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0][..], b"ab"].concat());
    }
}
