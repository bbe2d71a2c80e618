//! Sends what waits for viewers, in one thread.

use std::io::{ErrorKind, Read as _};
use std::net::{SocketAddr, TcpListener};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use contract::MonotonicNs;
use monitor::web::{Hosts, Reception};
use node::Node;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::channels::Channels;
use crate::gate::ViewerGate;
use crate::viewer::{Patience, Viewer};

/// Time for viewers to take the last messages, nanoseconds.
const GRACE_NS: u64 = 300_000_000;

/// A server of viewers. Dropping it ends its threads.
pub(crate) struct ViewerServer {
    /// Address it is bound to, with the actual port.
    pub address: SocketAddr,
    channels: Arc<Channels>,
    closing: Arc<AtomicBool>,
    /// `None` once the server closes.
    reception: Option<Reception>,
    thread: Option<JoinHandle<()>>,
}

/// Whom a server admits.
pub(crate) struct Admission {
    /// Names of the server besides loopback names and its addresses.
    pub hosts: Vec<String>,
    /// Origins of pages that may connect.
    pub origins: Vec<String>,
}

impl ViewerServer {
    /// Begins to serve the viewers of `channels` at `address`. `woken` becomes readable when there is something to send.
    ///
    /// # Errors
    /// If the address cannot be bound, or the operating system refuses a thread.
    pub fn open(
        address: SocketAddr,
        admission: Admission,
        channels: Arc<Channels>,
        woken: UnixStream,
        patience: Patience,
    ) -> std::io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let hosts = Hosts::new(address.ip(), &admission.hosts);
        let gate = ViewerGate::new(hosts, admission.origins, Arc::clone(&channels));
        let reception = Some(Reception::open("foxglove", listener, gate)?);
        let closing = Arc::new(AtomicBool::new(false));
        let mut desk = Desk {
            channels: Arc::clone(&channels),
            woken,
            closing: Arc::clone(&closing),
            viewers: Vec::new(),
            patience,
        };
        let builder = std::thread::Builder::new().name("viewers".into());
        let thread = Some(builder.spawn(move || desk.run())?);
        Ok(Self { address, channels, closing, reception, thread })
    }
}

impl Drop for ViewerServer {
    fn drop(&mut self) {
        self.reception = None;
        self.closing.store(true, Ordering::SeqCst);
        self.channels.wake();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct Desk {
    channels: Arc<Channels>,
    woken: UnixStream,
    closing: Arc<AtomicBool>,
    viewers: Vec<Viewer>,
    patience: Patience,
}

impl Desk {
    fn run(&mut self) {
        let mut until = None::<MonotonicNs>;
        loop {
            let now = Node::now();
            for arrival in self.channels.arrivals() {
                self.viewers.push(Viewer::new(arrival, now));
            }
            let (channels, patience) = (&self.channels, &self.patience);
            self.viewers.retain_mut(|viewer| viewer.turn(channels, patience, now));
            if self.closing.load(Ordering::SeqCst) {
                // A viewer that does not read is not waited for.
                let until = *until.get_or_insert(now.plus_ns(GRACE_NS));
                if now >= until || self.viewers.iter().all(|viewer| !viewer.is_behind()) {
                    self.viewers.iter_mut().for_each(Viewer::close);
                    return;
                }
            }
            self.wait(until, now);
        }
    }

    /// Waits for a socket, for something to send, or until viewers are due to be asked whether they are there.
    fn wait(&mut self, until: Option<MonotonicNs>, now: MonotonicNs) {
        let idle_ns = (!self.viewers.is_empty()).then_some(self.patience.ping_ns / 2);
        let closing_ns = until.map(|until| until.since_ns(now));
        let timeout = idle_ns
            .into_iter()
            .chain(closing_ns)
            .min()
            .map(|ns| Timespec { tv_sec: (ns / 1_000_000_000) as i64, tv_nsec: (ns % 1_000_000_000) as _ });
        let mut sockets = vec![PollFd::new(&self.woken, PollFlags::IN)];
        for viewer in &self.viewers {
            let events = if viewer.is_behind() { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
            sockets.push(PollFd::new(viewer.stream(), events));
        }
        // A signal ends the wait early, which does no harm.
        let _ = poll(&mut sockets, timeout.as_ref());
        let mut bytes = [0; 256];
        loop {
            match (&self.woken).read(&mut bytes) {
                Ok(count) if count == bytes.len() => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                _ => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::TcpStream;

    use super::*;

    fn open(patience: Patience) -> (ViewerServer, Arc<Channels>) {
        let (channels, woken) = Channels::new("test").unwrap();
        let admission = Admission { hosts: Vec::new(), origins: Vec::new() };
        let address = SocketAddr::from(([127, 0, 0, 1], 0));
        let server = ViewerServer::open(address, admission, Arc::clone(&channels), woken, patience).unwrap();
        (server, channels)
    }

    fn connect(address: SocketAddr) -> TcpStream {
        let mut stream = TcpStream::connect(address).unwrap();
        write!(
            stream,
            "GET / HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n"
        )
        .unwrap();
        stream
    }

    /// P-FOXGLOVE-SILENT: A socket that does not finish the handshake is closed after 5 s. A viewer
    /// that sends nothing for 10 s is sent a ping, and closed if it does not answer within 20 s;
    /// none is closed without a ping.
    #[test]
    fn a_viewer_that_stays_silent_is_closed() {
        let (server, channels) =
            open(Patience { ping_ns: 20_000_000, answer_ns: 40_000_000, drain_ns: 40_000_000 });
        let mut silent = connect(server.address);
        let mut all = Vec::new();
        silent.read_to_end(&mut all).unwrap();
        let text = String::from_utf8_lossy(&all);
        assert!(text.starts_with("HTTP/1.1 101 ") && text.contains("serverInfo"), "{text}");
        assert!(text.contains("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{text}");
        while channels.viewers() > 0 {
            std::thread::yield_now();
        }
        drop(server);
    }
}
