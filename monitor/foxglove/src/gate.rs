//! Decides which viewers may connect.
//!
//! A page of any server can open a WebSocket to this machine, and browsers let it read what comes. They say whose page it is,
//! in Origin; programs that are no browsers send none.

use std::io::Write as _;
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

use monitor::web::gate::{shortened, unknown_host};
use monitor::web::hosts::is_loopback_origin;
use monitor::web::{Head, Hosts, Rejection, Served, Service};
use tungstenite::handshake::derive_accept_key;

use crate::channels::Channels;
use crate::protocol::SUBPROTOCOLS;

/// How long the answer to a handshake may take: it is shorter than any socket's buffer.
const HANDSHAKE_TIME: Duration = Duration::from_secs(1);

/// The rules for viewers of one server.
pub(crate) struct ViewerGate {
    hosts: Hosts,
    /// Origins whose pages may connect besides those of this machine, in lower case.
    origins: Vec<String>,
    channels: Arc<Channels>,
}

impl ViewerGate {
    pub fn new(hosts: Hosts, origins: Vec<String>, channels: Arc<Channels>) -> Self {
        Self { hosts, origins, channels }
    }

    fn admits_origin(&self, origin: &str, host: &str) -> bool {
        is_loopback_origin(origin)
            || self.hosts.is_own_origin(origin, host)
            || self.origins.iter().any(|named| named.eq_ignore_ascii_case(origin))
    }

    /// Whether viewers that are named may connect from a page of this request's origin.
    fn check(&self, head: &Head) -> Result<(), Rejection> {
        let host = head.header("host").unwrap_or_default();
        if !self.hosts.knows(host) {
            return Err(unknown_host(host));
        }
        if let Some(origin) = head.header("origin")
            && !self.admits_origin(origin, host)
        {
            let origin = shortened(origin);
            return Err(Rejection::new(
                403,
                format!(
                    "a viewer in a browser needs to be named, got one of {origin:?}; start the monitor with \
                     --foxglove-origin {origin} if it may see the mission"
                ),
            ));
        }
        if head.method != "GET" || head.length > 0 {
            return Err(Rejection::new(405, "viewers connect by GET without a body"));
        }
        Ok(())
    }
}

/// The subprotocol to speak with a viewer that lists those it speaks.
fn subprotocol(head: &Head) -> Result<&'static str, Rejection> {
    let spoken = SUBPROTOCOLS.into_iter().find(|name| head.lists("sec-websocket-protocol", name));
    spoken.ok_or_else(|| {
        let offered = head.header("sec-websocket-protocol").map_or("nothing", shortened);
        let need = SUBPROTOCOLS.join(" or ");
        Rejection::new(400, format!("a viewer needs to speak {need}, got {offered}"))
    })
}

impl Service for ViewerGate {
    fn admit(&mut self, head: &Head) -> Result<(), Rejection> {
        self.check(head)?;
        if !head.lists("upgrade", "websocket") || !head.lists("connection", "upgrade") {
            return Err(Rejection::new(426, "viewers connect by WebSocket, as Foxglove and Lichtblick do"));
        }
        if head.header("sec-websocket-version") != Some("13") {
            return Err(Rejection::new(426, "the version of WebSocket needs to be 13"));
        }
        if head.header("sec-websocket-key").is_none_or(|key| key.len() != 24) {
            return Err(Rejection::new(400, "a handshake needs a Sec-WebSocket-Key of 24 characters"));
        }
        subprotocol(head).map(drop)
    }

    fn is_keyed(&self, _head: &Head) -> bool {
        false
    }

    fn answer(&mut self, head: &Head, _body: &[u8]) -> Result<Served, Rejection> {
        let subprotocol = subprotocol(head)?;
        let accept = derive_accept_key(head.header("sec-websocket-key").unwrap_or_default().as_bytes());
        let answer = format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Accept: {accept}\r\nSec-WebSocket-Protocol: {subprotocol}\r\n\r\n"
        );
        let place = self.channels.place()?;
        Ok(Served::Handed(Box::new(move |stream: TcpStream, rest| {
            let sent = stream
                .set_write_timeout(Some(HANDSHAKE_TIME))
                .and_then(|()| (&stream).write_all(answer.as_bytes()))
                .and_then(|()| stream.set_nonblocking(true));
            match sent {
                Ok(()) => place.arrive(stream, rest),
                Err(error) => tracing::debug!("a viewer is gone: {error}"),
            }
        })))
    }

    fn headers(&self) -> &'static str {
        "Cache-Control: no-store\r\nUpgrade: websocket\r\nX-Content-Type-Options: nosniff\r\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(origins: &[&str], hosts: &[&str], changed: &[(&str, &str)]) -> u16 {
        let words = |list: &[&str]| list.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
        let hosts = Hosts::new([127, 0, 0, 1].into(), &words(hosts));
        let channels = Channels::new("test").unwrap().0;
        let mut gate = ViewerGate::new(hosts, words(origins), channels);
        let mut head =
            "GET / HTTP/1.1\nHost: localhost:8765\nUpgrade: websocket\nConnection: keep-alive, Upgrade\n\
            Sec-WebSocket-Version: 13\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\n\
            Sec-WebSocket-Protocol: foxglove.websocket.v1"
                .to_owned();
        for (old, new) in changed {
            assert!(head.contains(old), "{old}");
            head = head.replace(old, new);
        }
        let head = format!("{}\r\n\r\n", head.replace('\n', "\r\n"));
        match Head::parse(head.as_bytes()) {
            Ok(whole) => gate.admit(&whole.unwrap().0).err().map_or(101, |rejection| rejection.0),
            Err(rejection) => rejection.0,
        }
    }

    /// P-FOXGLOVE-GATE: The Foxglove server accepts programs, which send no Origin, and pages of
    /// this machine or of origins that `--foxglove-origin` names; a page of another server, or a
    /// request for an unknown host, gets nothing.
    #[test]
    fn pages_of_other_servers_are_no_viewers_unless_they_are_named() {
        let from = |origins: &[&str], origin: &str| {
            status(origins, &[], &[("Host: ", &format!("Origin: {origin}\nHost: "))])
        };
        assert_eq!(status(&[], &[], &[]), 101, "a program");
        for origin in ["http://localhost:8080", "http://127.0.0.1:3000", "https://[::1]"] {
            assert_eq!(from(&[], origin), 101, "{origin}");
        }
        let foreign = [
            "https://app.foxglove.dev",
            "http://evil.example",
            "http://localhost.evil.example",
            "null",
            "file://",
            "",
        ];
        for origin in foreign {
            assert_eq!(from(&[], origin), 403, "{origin:?}");
        }
        let named = ["https://app.foxglove.dev", "file://"];
        assert_eq!((from(&named, "https://app.foxglove.dev"), from(&named, "FILE://")), (101, 101));
        for origin in
            ["http://app.foxglove.dev", "https://app.foxglove.dev.evil.example", "https://app.foxglove.dev:1"]
        {
            assert_eq!(from(&named, origin), 403, "{origin}");
        }
    }

    /// P-FOXGLOVE-GATE.
    #[test]
    fn a_handshake_needs_a_known_host_and_a_known_protocol() {
        for host in ["evil.example:8765", "evil.example", "0.0.0.0:8765", ""] {
            assert_eq!(status(&[], &[], &[("localhost:8765", host)]), 421, "{host}");
        }
        assert_eq!(status(&[], &["rover.example"], &[("localhost:8765", "rover.example:9000")]), 101);
        for (old, new, need) in [
            ("GET", "POST", 405),
            ("Upgrade: websocket\n", "", 426),
            ("keep-alive, Upgrade", "keep-alive", 426),
            ("Version: 13", "Version: 8", 426),
            ("dGhlIHNhbXBsZSBub25jZQ==", "short", 400),
            ("foxglove.websocket.v1", "graphql-ws", 400),
            ("foxglove.websocket.v1", "foxglove.websocket.v10", 400),
            ("Sec-WebSocket-Protocol: foxglove.websocket.v1", "Via: x", 400),
            ("foxglove.websocket.v1", "foxglove.sdk.v1.1, foxglove.sdk.v1", 101),
            ("Version: 13", "Version: 13\nContent-Length: 3", 405),
        ] {
            assert_eq!(status(&[], &[], &[(old, new)]), need, "{new}");
        }
    }
}
