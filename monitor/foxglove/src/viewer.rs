//! The connection of one viewer.

use std::io::ErrorKind;
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

/// When a viewer that says nothing is asked whether it is there, and when it is given up, nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience {
    /// Silence after which it is sent a ping, which every WebSocket client answers.
    pub ping_ns: u64,
    /// Silence after which its connection is closed.
    pub silent_ns: u64,
}

impl Default for Patience {
    fn default() -> Self {
        Self { ping_ns: 10_000_000_000, silent_ns: 30_000_000_000 }
    }
}

/// A viewer.
pub(crate) struct Viewer {
    number: u64,
    socket: WebSocket<TcpStream>,
    /// When something came from it last.
    heard: MonotonicNs,
    /// When it was sent a ping last.
    pinged: MonotonicNs,
    /// Whether its socket takes no more at present.
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
        let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
        Self { number: viewer, socket, heard: now, pinged: now, blocked: false, more: true }
    }

    pub fn stream(&self) -> &TcpStream {
        self.socket.get_ref()
    }

    /// Whether something waits to be sent.
    pub fn is_behind(&self) -> bool {
        self.blocked || self.more
    }

    /// Reads its requests and sends what waits for it, as far as the socket allows; false if it is gone.
    pub fn turn(&mut self, channels: &Channels, patience: &Patience, now: MonotonicNs) -> bool {
        let stays = !channels.is_dismissed(self.number)
            && self.read(channels, now)
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

    fn keep_alive(&mut self, patience: &Patience, now: MonotonicNs) -> bool {
        if now.since_ns(self.heard) >= patience.silent_ns {
            tracing::debug!("a viewer is silent, and is given up");
            return false;
        }
        if now.since_ns(self.heard.max(self.pinged)) < patience.ping_ns {
            return true;
        }
        self.pinged = now;
        // Behind what its socket has not taken, it would say nothing of the viewer.
        self.blocked || !is_gone(self.socket.send(Message::Ping(Bytes::new())), &mut self.blocked)
    }

    fn write(&mut self, channels: &Channels) -> bool {
        if self.blocked && is_gone(self.socket.flush(), &mut self.blocked) {
            return false;
        }
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
