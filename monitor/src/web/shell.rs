//! The page's sockets: a bounded number of connections, each in a thread of its own.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use contract::{MonotonicNs, Order};
use node::{Exit, Failure, Node};

use super::gate::{Answer, Gate, HEAD_BYTES_MAX, HEADERS, Head, Rejection};
use crate::history::{Cursor, Frame};
use crate::{History, Screen, Wish};

/// Most connections served at once; more get status 503.
pub const CONNECTIONS_MAX: usize = 32;

/// Most connections at once including those that get status 503; more are closed without an answer.
const THREADS_MAX: usize = 2 * CONNECTIONS_MAX;

/// Most orders that wait for the next turn of the work loop.
const ORDERS_MAX: usize = 16;

/// How long a request may take to arrive, nanoseconds.
const ARRIVAL_NS: u64 = 5_000_000_000;

/// How long a client may accept no data before its connection is closed.
const STALL: Duration = Duration::from_secs(10);

/// Interval of comments on an idle event stream, which show that it is alive.
const IDLE: Duration = Duration::from_secs(1);

/// Bytes collected for one write.
const WRITE_BYTES: usize = 64 << 10;

/// How long closing waits for clients to read the end of the history, nanoseconds.
const CLOSE_NS: u64 = 400_000_000;

/// A page being served. Dropping it ends all connections.
#[derive(Debug)]
pub struct Page {
    address: SocketAddr,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    gate: Gate,
    history: Arc<Mutex<History>>,
    /// Notified when the history has grown.
    changed: Condvar,
    orders: Mutex<VecDeque<Order>>,
    connections: AtomicUsize,
    policies: AtomicUsize,
    closing: AtomicBool,
}

/// Counts one in `self.0` until it is dropped.
struct CountGuard<'a>(&'a AtomicUsize);

impl<'a> CountGuard<'a> {
    fn new(counter: &'a AtomicUsize) -> Self {
        counter.fetch_add(1, Ordering::SeqCst);
        Self(counter)
    }
}

impl Drop for CountGuard<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Counts one connection until its thread ends.
struct ConnectionSlot(Arc<Shared>);

impl ConnectionSlot {
    /// A slot, and the number of connections including it.
    fn take(shared: &Arc<Shared>) -> (Self, usize) {
        let number = shared.connections.fetch_add(1, Ordering::SeqCst) + 1;
        (Self(Arc::clone(shared)), number)
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Page {
    /// Serves the history at `address`, with orders if `control`.
    ///
    /// # Errors
    /// If the address cannot be bound.
    pub fn open(address: SocketAddr, control: bool, history: Arc<Mutex<History>>) -> Result<Self, Failure> {
        let unavailable = |error: std::io::Error| {
            let message =
                format!("--web {address}: {error}; use another address, or port 0 for any free one");
            Failure::new(Exit::Usage, message)
        };
        let listener = TcpListener::bind(address).map_err(unavailable)?;
        let address = listener.local_addr().map_err(unavailable)?;
        let key = control.then(|| node::random_run().map(|nonce| nonce.to_string())).transpose()?;
        let fragment = key.as_ref().map_or(String::new(), |key| format!("#key={key}"));
        tracing::info!("page at http://{address}/{fragment}");
        if !address.ip().is_loopback() {
            tracing::warn!("anyone who can reach {address} can read the page: nothing on it is encrypted");
        }
        let shared = Arc::new(Shared {
            gate: Gate::new(address, key),
            history,
            changed: Condvar::new(),
            orders: Mutex::default(),
            connections: AtomicUsize::new(0),
            policies: AtomicUsize::new(0),
            closing: AtomicBool::new(false),
        });
        let served = Arc::clone(&shared);
        let accept = move || accept(&listener, &served);
        std::thread::Builder::new().name("page".into()).spawn(accept).map_err(unavailable)?;
        Ok(Self { address, shared })
    }

    /// Address it is served at, with the actual port.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The history, locked, to add to it.
    pub fn history(&self) -> MutexGuard<'_, History> {
        self.shared.history()
    }

    /// Wakes the readers after the history has grown.
    pub fn notify(&self) {
        self.shared.changed.notify_all();
    }

    /// Whether a client displays policies.
    #[must_use]
    pub fn wants_policy(&self) -> bool {
        self.shared.policies.load(Ordering::SeqCst) > 0
    }

    /// Orders received since the last call.
    #[must_use]
    pub fn orders(&self) -> VecDeque<Order> {
        std::mem::take(&mut *self.shared.orders.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Screen for Page {
    fn wants_policy(&self) -> bool {
        Page::wants_policy(self)
    }

    fn show(&mut self, _history: &History, _now: MonotonicNs) -> Result<Vec<Wish>, Failure> {
        self.notify();
        Ok(self.orders().into_iter().map(Wish::Order).collect())
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.shared.closing.store(true, Ordering::SeqCst);
        // A reader that saw it open still holds the lock, or already waits and is notified.
        drop(self.history());
        self.notify();
        let deadline = Node::now().plus_ns(CLOSE_NS);
        while self.shared.connections.load(Ordering::SeqCst) > 0 && Node::now() < deadline {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Shared {
    fn history(&self) -> MutexGuard<'_, History> {
        // A thread that panicked while reading did not change the history.
        self.history.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_closing(&self) -> bool {
        self.closing.load(Ordering::SeqCst)
    }

    /// Queues an order for the work loop, if a process can carry it out.
    fn order(&self, order: Order) -> Result<(), Rejection> {
        let history = self.history();
        let obeys = history.pacing().map(|pacing| pacing.obeys);
        let refusal = match (order, obeys) {
            (Order::HandOver(life), _) if !history.peers().is_live_planner(life) => {
                Some("a hand-over needs a running planner")
            }
            (Order::HandOver(_), _) | (_, Some(true)) => None,
            (_, Some(false)) => Some("this order needs a hopper-sim started with --control"),
            (_, None) => Some("hopper-sim has not reported yet"),
        };
        drop(history);
        if let Some(reason) = refusal {
            return Err(Rejection(409, reason.into()));
        }
        let mut orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        if orders.len() >= ORDERS_MAX {
            return Err(Rejection(503, "too many orders are waiting already; try again".into()));
        }
        orders.push_back(order);
        Ok(())
    }
}

fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    for stream in listener.incoming() {
        if shared.is_closing() {
            return;
        }
        let Ok(stream) = stream else {
            // For example out of file descriptors: do not spin.
            std::thread::sleep(Duration::from_millis(10));
            continue;
        };
        let (slot, number) = ConnectionSlot::take(shared);
        if number > THREADS_MAX {
            continue;
        }
        let serve = move || {
            if let Err(error) = connection(&stream, &slot.0, number > CONNECTIONS_MAX) {
                tracing::debug!("a client of the page disconnected: {error}");
            }
        };
        if let Err(error) = std::thread::Builder::new().name("client".into()).spawn(serve) {
            tracing::warn!("a client of the page was refused: {error}");
        }
    }
}

/// Serves a client; if the server is `full`, with status 503.
fn connection(mut stream: &TcpStream, shared: &Shared, full: bool) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(STALL))?;
    let answer = match full {
        true => Err(Rejection(503, format!("{CONNECTIONS_MAX} connections are open already"))),
        false => request(stream, &shared.gate),
    };
    let answer = answer.and_then(|answer| match answer {
        Answer::Order(order) => shared.order(order).map(|()| Answer::Order(order)),
        other => Ok(other),
    });
    match answer {
        Ok(Answer::Asset(asset)) => respond(stream, "200 OK", asset.kind, asset.text),
        Ok(Answer::Order(_)) => respond(stream, "202 Accepted", "text/plain", "told\n"),
        Ok(Answer::Events { policy }) => events(stream, shared, policy),
        Err(rejection) => {
            let status = format!("{} {}", rejection.0, rejection.phrase());
            tracing::debug!(status, "refused a request: {}", rejection.1);
            respond(stream, &status, "text/plain; charset=utf-8", &format!("{}\n", rejection.1))?;
            // Remaining input is read and dropped: closing with unread data could discard the answer.
            stream.shutdown(std::net::Shutdown::Write)?;
            stream.set_read_timeout(Some(Duration::from_millis(100)))?;
            let mut rest = [0; 1024];
            (0..16).try_for_each(|_| stream.read(&mut rest).map(drop)).or(Ok(()))
        }
    }
}

/// Reads one request and decides how to answer it.
fn request(stream: &TcpStream, gate: &Gate) -> Result<Answer, Rejection> {
    let deadline = Node::now().plus_ns(ARRIVAL_NS);
    let mut bytes = Vec::new();
    let (head, size) = loop {
        if let Some(whole) = Head::parse(&bytes)? {
            break whole;
        }
        more(stream, &mut bytes, HEAD_BYTES_MAX, deadline)?;
    };
    gate.admit(&head)?;
    while bytes.len() < size + head.length {
        more(stream, &mut bytes, size + head.length, deadline)?;
    }
    gate.answer(&head, &bytes[size..size + head.length])
}

/// Reads more, up to `most` bytes in total.
fn more(
    mut stream: &TcpStream,
    bytes: &mut Vec<u8>,
    most: usize,
    deadline: MonotonicNs,
) -> Result<(), Rejection> {
    let late = || Rejection(408, "the request took too long to arrive".into());
    let left_ns = deadline.since_ns(Node::now());
    if left_ns == 0 {
        return Err(late());
    }
    let mut piece = [0; 2048];
    let room = piece.len().min(most - bytes.len());
    let read = stream
        .set_read_timeout(Some(Duration::from_nanos(left_ns)))
        .and_then(|()| stream.read(&mut piece[..room]));
    match read {
        Ok(0) => Err(Rejection(400, "the request was cut short".into())),
        Ok(count) => {
            bytes.extend_from_slice(&piece[..count]);
            Ok(())
        }
        Err(error) if error.kind() == ErrorKind::Interrupted => Ok(()),
        Err(_) => Err(late()),
    }
}

fn respond(mut stream: &TcpStream, status: &str, kind: &str, text: &str) -> std::io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\n{HEADERS}Content-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        text.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(text.as_bytes())
}

/// Sends the history from its beginning as server-sent events, as fast as the client reads.
fn events(mut stream: &TcpStream, shared: &Shared, policy: bool) -> std::io::Result<()> {
    let counted = policy.then(|| CountGuard::new(&shared.policies));
    let head = format!(
        "HTTP/1.1 200 OK\r\n{HEADERS}Content-Type: text/event-stream\r\nConnection: close\r\n\r\nretry: 1000\n\n"
    );
    stream.write_all(head.as_bytes())?;
    let mut cursor = if policy { Cursor::of_policies() } else { Cursor::default() };
    loop {
        let text = frames(shared, &mut cursor);
        stream.write_all(text.as_bytes())?;
        if text.is_empty() && shared.is_closing() {
            drop(counted);
            return stream.write_all(b"event: bye\ndata: {}\n\n");
        }
        if text.is_empty() && !wait(shared, &mut cursor) {
            stream.write_all(b":\n\n")?;
        }
    }
}

/// The next frames for a reader, up to about [`WRITE_BYTES`].
fn frames(shared: &Shared, cursor: &mut Cursor) -> String {
    let mut text = String::new();
    while text.len() < WRITE_BYTES {
        // The lock is released between two frames: the work loop waits for one at most.
        let Some(Frame { event, data }) = shared.history().next(cursor, Node::now()) else { break };
        text += &format!("event: {event}\ndata: {data}\n\n");
    }
    text
}

/// Waits until the history may have grown; false if nothing happened for [`IDLE`].
fn wait(shared: &Shared, cursor: &mut Cursor) -> bool {
    let history = shared.history();
    if shared.is_closing() || history.has_news(cursor) {
        return true;
    }
    let woken = shared.changed.wait_timeout(history, IDLE);
    woken.is_ok_and(|(_, timeout)| !timeout.timed_out())
}
