//! How packets leave this machine.

use std::collections::VecDeque;
use std::io::{ErrorKind, Write as _};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, TcpStream, UdpSocket};

use node::{Exit, Failure};

/// Most clients at once.
const CLIENTS_MAX: usize = 8;

/// Bytes that wait for a client at most; one that is farther behind is left.
const WAITING_MAX: usize = 1 << 20;

/// Where packets go.
pub enum Transport {
    /// A datagram a packet. What is not heard is lost, as on a radio link.
    Udp(UdpSocket),
    /// Packets one after another, to everyone who has connected.
    Tcp(Clients),
}

/// Whoever has connected.
pub struct Clients {
    listener: TcpListener,
    streams: Vec<Client>,
}

struct Client {
    stream: TcpStream,
    address: SocketAddr,
    waiting: VecDeque<u8>,
}

impl Transport {
    /// Sends datagrams to `address`.
    ///
    /// # Errors
    /// If there is no socket for that.
    pub fn udp(address: SocketAddr) -> Result<Self, Failure> {
        let own: SocketAddr = match address {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let open = || {
            let socket = UdpSocket::bind(own)?;
            socket.connect(address)?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        let refuse = |error: std::io::Error| {
            Failure::new(
                Exit::Usage,
                format!("--udp cannot send to {address}: {error}; name another address"),
            )
        };
        open().map(Transport::Udp).map_err(refuse)
    }

    /// Waits for clients at `address`.
    ///
    /// # Errors
    /// If nobody can be waited for there.
    pub fn tcp(address: SocketAddr) -> Result<Self, Failure> {
        let open = || {
            let listener = TcpListener::bind(address)?;
            listener.set_nonblocking(true)?;
            Ok(listener)
        };
        let refuse = |error: std::io::Error| {
            Failure::new(
                Exit::Usage,
                format!("--tcp cannot listen on {address}: {error}; name another address"),
            )
        };
        let listener = open().map_err(refuse)?;
        Ok(Transport::Tcp(Clients { listener, streams: Vec::new() }))
    }

    /// The address that was asked for; of TCP the one that is listened on.
    ///
    /// # Errors
    /// If the socket has none.
    pub fn address(&self) -> std::io::Result<SocketAddr> {
        match self {
            Transport::Udp(socket) => socket.peer_addr(),
            Transport::Tcp(clients) => clients.listener.local_addr(),
        }
    }

    /// Whether a packet would reach anybody, as far as that is known: without a client packets wait.
    pub fn is_open(&mut self) -> bool {
        match self {
            Transport::Udp(_) => true,
            Transport::Tcp(clients) => {
                clients.accept();
                clients.streams.retain_mut(Client::flush);
                !clients.streams.is_empty()
            }
        }
    }

    /// Whether everything that was sent has left.
    pub fn is_flushed(&self) -> bool {
        match self {
            Transport::Udp(_) => true,
            Transport::Tcp(clients) => clients.streams.iter().all(|client| client.waiting.is_empty()),
        }
    }

    /// Sends a packet, waiting for nobody.
    pub fn send(&mut self, packet: &[u8]) {
        match self {
            Transport::Udp(socket) => {
                // That nobody listens is told of a datagram before; this one is sent again then.
                if socket.send(packet).is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused) {
                    let _ = socket.send(packet);
                }
            }
            Transport::Tcp(clients) => clients.streams.retain_mut(|client| {
                client.waiting.extend(packet);
                let keeps_up = client.waiting.len() <= WAITING_MAX;
                if !keeps_up {
                    tracing::warn!("{} is {WAITING_MAX} bytes behind and is left", client.address);
                }
                keeps_up && client.flush()
            }),
        }
    }
}

impl Clients {
    fn accept(&mut self) {
        // A few at a look: whoever keeps connecting keeps nobody from the mission.
        for _ in 0..CLIENTS_MAX {
            let Ok((stream, address)) = self.listener.accept() else { return };
            if self.streams.len() == CLIENTS_MAX {
                tracing::warn!("{address} is turned away: at most {CLIENTS_MAX} connect at once");
                continue;
            }
            if stream.set_nonblocking(true).is_ok() {
                tracing::info!("{address} has connected");
                self.streams.push(Client { stream, address, waiting: VecDeque::new() });
            }
        }
    }
}

impl Client {
    /// Sends what waits, as far as it can be sent now; whether the client is still there.
    fn flush(&mut self) -> bool {
        while !self.waiting.is_empty() {
            match self.stream.write(self.waiting.as_slices().0) {
                Ok(0) => return self.left(),
                Ok(written) => drop(self.waiting.drain(..written)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return true,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return self.left(),
            }
        }
        true
    }

    fn left(&self) -> bool {
        tracing::info!("{} has left", self.address);
        false
    }
}
