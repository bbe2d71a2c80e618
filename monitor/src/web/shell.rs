//! The page's sockets: a bounded number of connections, each in a thread of its own.

use std::borrow::Cow;
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

/// Most requests read or answered at once; more get status 503. A stream of events is none: whatever streams are
/// open, there is room for files and orders.
pub const REQUESTS_MAX: usize = 32;

/// Most streams of the history at once, without and with those that have the key; more get status 503. The operator's page
/// has a place that no other reader can take.
pub const HISTORIES_MAX: usize = 24;
const KEYED_HISTORIES_MAX: usize = HISTORIES_MAX + 4;

/// Most streams of policies at once, without and with those that have the key; more get status 503.
pub const POLICIES_MAX: usize = 8;
const KEYED_POLICIES_MAX: usize = POLICIES_MAX + 4;

/// Most connections at once including those that get status 503; more are closed without an answer.
const THREADS_MAX: usize = 2 * REQUESTS_MAX + KEYED_HISTORIES_MAX + KEYED_POLICIES_MAX;

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
    url: String,
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
    /// Connections that are not streams.
    requests: AtomicUsize,
    histories: AtomicUsize,
    policies: AtomicUsize,
    closing: AtomicBool,
}

/// Counts one in `self.0` until it is dropped.
struct CountGuard<'a>(&'a AtomicUsize);

impl<'a> CountGuard<'a> {
    /// A guard, unless as many as `most` count already.
    fn within(counter: &'a AtomicUsize, most: usize) -> Option<Self> {
        let guard = Self(counter);
        (counter.fetch_add(1, Ordering::SeqCst) < most).then_some(guard)
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
        let url = format!("http://{address}/{fragment}");
        tracing::info!("page at {url}");
        if !address.ip().is_loopback() {
            tracing::warn!("anyone who can reach {address} can read the page: nothing on it is encrypted");
        }
        let shared = Arc::new(Shared {
            gate: Gate::new(address, key),
            history,
            changed: Condvar::new(),
            orders: Mutex::default(),
            connections: AtomicUsize::new(0),
            requests: AtomicUsize::new(0),
            histories: AtomicUsize::new(0),
            policies: AtomicUsize::new(0),
            closing: AtomicBool::new(false),
        });
        let served = Arc::clone(&shared);
        let accept = move || accept(&listener, &served);
        std::thread::Builder::new().name("page".into()).spawn(accept).map_err(unavailable)?;
        Ok(Self { address, url, shared })
    }

    /// The page's address as the log shows it, with the key of orders if they are allowed.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
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

impl Screen for Arc<Page> {
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
            if let Err(error) = connection(&stream, &slot.0) {
                tracing::debug!("a client of the page disconnected: {error}");
            }
        };
        if let Err(error) = std::thread::Builder::new().name("client".into()).spawn(serve) {
            tracing::warn!("a client of the page was refused: {error}");
        }
    }
}

/// What a client gets.
enum Served<'a> {
    /// Status, content type and text.
    Text(&'static str, &'static str, Cow<'static, str>),
    /// Policies or the history, and the place among the streams.
    Stream(bool, CountGuard<'a>),
}

/// Serves a client; with status 503 if there is no room for what it asks for.
fn connection(mut stream: &TcpStream, shared: &Shared) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(STALL))?;
    let counted = CountGuard::within(&shared.requests, REQUESTS_MAX);
    let answer = match &counted {
        None => Err(Rejection(503, format!("{REQUESTS_MAX} requests are open already"))),
        Some(_) => request(stream, &shared.gate),
    };
    let served = answer.and_then(|answer| match answer {
        Answer::Asset(asset) => Ok(Served::Text("200 OK", asset.kind, asset.text.into())),
        Answer::Reason(cell, at) => {
            Ok(Served::Text("200 OK", "application/json", shared.history().reason_json(cell, at).into()))
        }
        Answer::Order(order) => {
            shared.order(order).map(|()| Served::Text("202 Accepted", "text/plain", "accepted\n".into()))
        }
        Answer::Events { policy, keyed } => {
            stream_slot(shared, policy, keyed).map(|slot| Served::Stream(policy, slot))
        }
    });
    match served {
        Ok(Served::Text(status, kind, text)) => respond(stream, status, kind, &text),
        Ok(Served::Stream(policy, slot)) => {
            drop(counted);
            events(stream, shared, policy, slot)
        }
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

/// A place among the streams, or why there is none.
fn stream_slot(shared: &Shared, policy: bool, keyed: bool) -> Result<CountGuard<'_>, Rejection> {
    let (counter, most) = match (policy, keyed) {
        (false, false) => (&shared.histories, HISTORIES_MAX),
        (false, true) => (&shared.histories, KEYED_HISTORIES_MAX),
        (true, false) => (&shared.policies, POLICIES_MAX),
        (true, true) => (&shared.policies, KEYED_POLICIES_MAX),
    };
    CountGuard::within(counter, most)
        .ok_or_else(|| Rejection(503, format!("{most} such streams are open already")))
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
fn events(
    mut stream: &TcpStream,
    shared: &Shared,
    policy: bool,
    slot: CountGuard<'_>,
) -> std::io::Result<()> {
    let head = format!(
        "HTTP/1.1 200 OK\r\n{HEADERS}Content-Type: text/event-stream\r\nConnection: close\r\n\r\nretry: 1000\n\n"
    );
    stream.write_all(head.as_bytes())?;
    let mut cursor = if policy { Cursor::of_policies() } else { Cursor::default() };
    loop {
        let text = frames(shared, &mut cursor);
        stream.write_all(text.as_bytes())?;
        if text.is_empty() && shared.is_closing() {
            drop(slot);
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
