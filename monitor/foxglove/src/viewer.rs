//! The connection of one viewer.
//!
//! A viewer shows that it is there by what it sends: every WebSocket client answers a ping. A viewer that reads slowly answers late,
//! since it first reads the messages ahead of the ping. As long as it makes room in a socket that was full, it is there too.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;

use contract::MonotonicNs;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, WebSocket};

use crate::channels::{Arrival, Channels, Next};
use crate::protocol::message_data;

/// Most bytes of a viewer's request.
const REQUEST_BYTES_MAX: usize = 64 << 10;

/// Most messages that are read or written before other viewers have their turn.
const MESSAGES_MAX: usize = 64;

/// When a viewer is sent a ping, and how long it may take to answer, nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience {
    /// Silence after which a ping is sent.
    pub ping_ns: u64,
    /// Time from the ping to its answer; then the connection is closed.
    pub answer_ns: u64,
    /// Time that a viewer has, after its full socket took something, to read what is in the buffers: some megabytes.
    pub drain_ns: u64,
}

impl Default for Patience {
    fn default() -> Self {
        Self { ping_ns: 10_000_000_000, answer_ns: 20_000_000_000, drain_ns: 60_000_000_000 }
    }
}

/// A socket that counts the bytes that it has taken.
struct CountingStream {
    stream: TcpStream,
    taken_bytes: u64,
}

impl Read for CountingStream {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.stream.read(bytes)
    }
}

impl Write for CountingStream {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.stream.write(bytes)?;
        self.taken_bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}

/// A viewer.
pub(crate) struct Viewer {
    number: u64,
    socket: WebSocket<CountingStream>,
    /// When something came from it last.
    heard: MonotonicNs,
    /// When it was sent the ping that it has not answered yet.
    pinged: Option<MonotonicNs>,
    /// When its socket last took something after it had been full.
    taken: Option<MonotonicNs>,
    /// Whether its socket is full.
    blocked: bool,
    /// Whether more is known to wait for it.
    more: bool,
}

/// How a socket took a message.
fn is_gone(result: Result<(), Error>, blocked: &mut bool) -> bool {
    match result {
        Ok(()) => {
            *blocked = false;
            false
        }
        Err(Error::Io(error)) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
            *blocked = true;
            false
        }
        Err(_) => true,
    }
}

impl Viewer {
    pub fn new(Arrival { viewer, stream, rest }: Arrival, now: MonotonicNs) -> Self {
        let config = WebSocketConfig::default()
            .max_message_size(Some(REQUEST_BYTES_MAX))
            .max_frame_size(Some(REQUEST_BYTES_MAX));
        let stream = CountingStream { stream, taken_bytes: 0 };
        let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
        Self { number: viewer, socket, heard: now, pinged: None, taken: None, blocked: false, more: true }
    }

    pub fn stream(&self) -> &TcpStream {
        &self.socket.get_ref().stream
    }

    /// Whether something waits to be sent.
    pub fn is_behind(&self) -> bool {
        self.blocked || self.more
    }

    /// Reads its requests and sends what waits for it, as far as the socket allows; false if it is gone.
    pub fn turn(&mut self, channels: &Channels, patience: &Patience, now: MonotonicNs) -> bool {
        let stays = !channels.is_dismissed(self.number)
            && self.read(channels, now)
            && self.flush(now)
            && self.keep_alive(patience, now)
            && self.write(channels);
        if !stays {
            channels.leave(self.number);
        }
        stays
    }

    /// Says goodbye, if the socket takes it.
    pub fn close(&mut self) {
        let _ = self.socket.close(None);
        let _ = self.socket.flush();
    }

    fn read(&mut self, channels: &Channels, now: MonotonicNs) -> bool {
        for _ in 0..MESSAGES_MAX {
            match self.socket.read() {
                Ok(message) => {
                    self.heard = now;
                    self.pinged = None;
                    if let Message::Text(text) = message {
                        channels.request(self.number, &text);
                    }
                }
                Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => return true,
                Err(Error::Io(error)) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return false,
            }
        }
        true
    }

    /// Sends what its full socket did not take before.
    fn flush(&mut self, now: MonotonicNs) -> bool {
        if !self.blocked {
            return true;
        }
        let before = self.socket.get_ref().taken_bytes;
        let gone = is_gone(self.socket.flush(), &mut self.blocked);
        if self.socket.get_ref().taken_bytes > before {
            self.taken = Some(now);
        }
        !gone
    }

    /// Sends a ping if one is due; false if the last one was not answered.
    fn keep_alive(&mut self, patience: &Patience, now: MonotonicNs) -> bool {
        let Some(pinged) = self.pinged else {
            if now.since_ns(self.heard) < patience.ping_ns {
                return true;
            }
            self.pinged = Some(now);
            // If the socket is full, the ping waits behind one message, and ahead of all others.
            return !is_gone(self.socket.send(Message::Ping(Bytes::new())), &mut self.blocked);
        };
        let reads = self.taken.is_some_and(|taken| now.since_ns(taken) < patience.drain_ns);
        if reads || now.since_ns(pinged) < patience.answer_ns {
            return true;
        }
        tracing::debug!("a viewer does not answer a ping, and is given up");
        false
    }

    fn write(&mut self, channels: &Channels) -> bool {
        self.more = !self.blocked;
        for _ in 0..MESSAGES_MAX {
            if self.blocked {
                self.more = false;
                return true;
            }
            let message = match channels.next(self.number) {
                Next::Text(text) => Message::text(text),
                Next::Message(id, message) => {
                    Message::binary(message_data(id, message.logged, &message.data))
                }
                Next::Nothing => {
                    self.more = false;
                    return true;
                }
            };
            if is_gone(self.socket.send(message), &mut self.blocked) {
                return false;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;
    use std::os::unix::net::UnixStream;
    use std::sync::Arc;

    use recording::{Channel, EncodedMessage, Topic};

    use super::*;

    const PATIENCE: Patience =
        Patience { ping_ns: seconds(10).0, answer_ns: seconds(20).0, drain_ns: seconds(60).0 };

    /// Size of a message, bytes. One a second is more than the slow viewer of these tests reads.
    const MESSAGE_BYTES: usize = 1 << 20;

    /// A viewer of the first channel, and its other end.
    struct Connection {
        channels: Arc<Channels>,
        viewer: Viewer,
        client: TcpStream,
        /// What the client has read.
        read: Vec<u8>,
        _woken: UnixStream,
    }

    const fn seconds(count: u64) -> MonotonicNs {
        MonotonicNs(count * 1_000_000_000)
    }

    impl Connection {
        fn open() -> Self {
            let (channels, woken) = Channels::new("test").unwrap();
            let listener = TcpListener::bind("127.0.0.1:0").unwrap();
            let client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            let (stream, _) = listener.accept().unwrap();
            client.set_nonblocking(true).unwrap();
            stream.set_nonblocking(true).unwrap();
            channels.place().unwrap().arrive(stream, Vec::new());
            let viewer = Viewer::new(channels.arrivals().pop().unwrap(), seconds(0));
            let subscription = r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]}"#;
            channels.request(viewer.number, subscription);
            Self { channels, viewer, client, read: Vec::new(), _woken: woken }
        }

        /// A second of a mission that sends more than the client reads, which is `bytes` at most; whether the viewer stays.
        fn pass(&mut self, second: u64, bytes: usize) -> bool {
            let (topic, now) = (Topic::Known(Channel::ALL[0]), seconds(second));
            let data = vec![0; MESSAGE_BYTES];
            self.channels.publish(EncodedMessage { topic, data, published: now, logged: now });
            let mut piece = vec![0; bytes];
            match self.client.read(&mut piece) {
                Ok(count) => self.read.extend_from_slice(&piece[..count]),
                Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock),
            }
            self.viewer.turn(&self.channels, &PATIENCE, now)
        }

        /// Pings and binary messages among the frames that the client has read.
        fn frames(&self) -> (usize, usize) {
            let (mut pings, mut messages, mut rest) = (0, 0, self.read.as_slice());
            while let [first, short, ..] = *rest {
                let (head, size) = match short {
                    126 => (
                        4,
                        rest.get(2..4)
                            .map(|bytes| usize::from(u16::from_be_bytes(bytes.try_into().unwrap()))),
                    ),
                    127 => (
                        10,
                        rest.get(2..10).map(|bytes| u64::from_be_bytes(bytes.try_into().unwrap()) as usize),
                    ),
                    size => (2, Some(usize::from(size))),
                };
                pings += usize::from(first == 0x89);
                messages += usize::from(first == 0x82);
                let Some(next) = size.and_then(|size| rest.get(head + size..)) else { break };
                rest = next;
            }
            (pings, messages)
        }
    }

    /// P-FOXGLOVE-SLOW: A viewer that reads less than is sent to it loses messages and stays
    /// connected, also before it has read up to the ping. It is closed once its full socket has
    /// accepted nothing for 60 s.
    #[test]
    fn a_viewer_that_reads_slowly_stays_until_it_reads_nothing() {
        let mut connection = Connection::open();
        for second in 1..=200 {
            assert!(connection.pass(second, 256 << 10), "given up after {second} s");
        }
        let (pings, messages) = connection.frames();
        assert!(messages < 100, "{messages} messages: it was never behind");
        assert_eq!(pings, 1, "one that is not answered yet; {messages} messages");
        let stayed = (201..400).take_while(|second| connection.pass(*second, 0)).count();
        assert!((1..=60).contains(&stayed), "{stayed} s after it has read something");
    }

    /// P-FOXGLOVE-SLOW. A slow viewer that answers is sent a ping again after each answer.
    #[test]
    fn a_slow_viewer_is_sent_pings_as_any_other() {
        let mut connection = Connection::open();
        let mut answered = 0;
        for second in 1..=200 {
            assert!(connection.pass(second, 256 << 10), "given up after {second} s");
            if connection.frames().0 > answered {
                answered += 1;
                // A masked pong without payload.
                connection.client.write_all(&[0x8a, 0x80, 0, 0, 0, 0]).unwrap();
            }
        }
        assert!(answered > 2, "{answered} pings");
    }

    /// P-FOXGLOVE-SILENT. No viewer is closed without a ping, however long this process was
    /// stopped; the answer to the ping counts.
    #[test]
    fn nobody_is_given_up_without_a_ping() {
        let mut connection = Connection::open();
        let mut at = |second| connection.viewer.turn(&connection.channels, &PATIENCE, seconds(second));
        assert!([9, 1000, 1019].map(&mut at).iter().all(|stays| *stays), "a ping was due at 1000 s");
        connection.client.write_all(&[0x8a, 0x80, 0, 0, 0, 0]).unwrap();
        assert!([1020, 1030, 1049].map(&mut at).iter().all(|stays| *stays), "and again at 1030 s");
        assert!(!at(1050), "which was not answered");
    }
}
