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
use crate::chronicle::{Cursor, Frame};
use crate::{Chronicle, Screen, Wish};

/// Connections at once; whoever comes beyond is told so.
pub const CONNECTIONS_MAX: usize = 32;

/// Connections at once, those that are told so included; whoever comes beyond finds the door closed.
const THREADS_MAX: usize = 2 * CONNECTIONS_MAX;

/// Orders that wait for the next turn of the work loop.
const ORDERS_MAX: usize = 16;

/// How long a request may take to arrive, nanoseconds.
const ARRIVAL_NS: u64 = 5_000_000_000;

/// How long a client may take nothing before it is let go.
const STALL: Duration = Duration::from_secs(10);

/// An idle stream says this often that it lives.
const IDLE: Duration = Duration::from_secs(1);

/// Bytes that are put together for one write.
const WRITE_BYTES: usize = 64 << 10;

/// How long the end of the account may take to reach its readers, nanoseconds.
const FAREWELL_NS: u64 = 400_000_000;

/// A page under way; dropping it tells its clients goodbye.
#[derive(Debug)]
pub struct Page {
    address: SocketAddr,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    gate: Gate,
    account: Arc<Mutex<Chronicle>>,
    /// Rings when the account has news.
    bell: Condvar,
    orders: Mutex<VecDeque<Order>>,
    connections: AtomicUsize,
    policies: AtomicUsize,
    closing: AtomicBool,
}

/// Counts for as long as it lives.
struct Counted<'a>(&'a AtomicUsize);

impl<'a> Counted<'a> {
    fn new(counter: &'a AtomicUsize) -> Self {
        counter.fetch_add(1, Ordering::SeqCst);
        Self(counter)
    }
}

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A connection's place among all, from its coming to the end of its thread.
struct Place(Arc<Shared>);

impl Place {
    /// A place and its number, 1 for the only one.
    fn take(shared: &Arc<Shared>) -> (Self, usize) {
        let number = shared.connections.fetch_add(1, Ordering::SeqCst) + 1;
        (Self(Arc::clone(shared)), number)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Page {
    /// Serves the account at `address`, with orders if `control`.
    ///
    /// # Errors
    /// If the address cannot be had.
    pub fn open(address: SocketAddr, control: bool, account: Arc<Mutex<Chronicle>>) -> Result<Self, Failure> {
        let unavailable = |error: std::io::Error| {
            let message =
                format!("--web {address} cannot be had: {error}; name another, or port 0 for any free one");
            Failure::new(Exit::Usage, message)
        };
        let listener = TcpListener::bind(address).map_err(unavailable)?;
        let address = listener.local_addr().map_err(unavailable)?;
        let key = control.then(|| node::random_run().map(|nonce| nonce.to_string())).transpose()?;
        let fragment = key.as_ref().map_or(String::new(), |key| format!("#key={key}"));
        tracing::info!("page at http://{address}/{fragment}");
        if !address.ip().is_loopback() {
            tracing::warn!("the page can be read by whoever reaches {address}: nothing on it is encrypted");
        }
        let shared = Arc::new(Shared {
            gate: Gate::new(address, key),
            account,
            bell: Condvar::new(),
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

    /// Where it is served.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The account, to add to it.
    pub fn account(&self) -> MutexGuard<'_, Chronicle> {
        self.shared.account()
    }

    /// Tells readers that there is news.
    pub fn ring(&self) {
        self.shared.bell.notify_all();
    }

    /// Whether somebody wants to see policies.
    #[must_use]
    pub fn wants_policy(&self) -> bool {
        self.shared.policies.load(Ordering::SeqCst) > 0
    }

    /// Orders that came since.
    #[must_use]
    pub fn orders(&self) -> VecDeque<Order> {
        std::mem::take(&mut *self.shared.orders.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Screen for Page {
    fn wants_policy(&self) -> bool {
        Page::wants_policy(self)
    }

    fn show(&mut self, _account: &Chronicle, _now: MonotonicNs) -> Result<Vec<Wish>, Failure> {
        self.ring();
        Ok(self.orders().into_iter().map(Wish::Order).collect())
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.shared.closing.store(true, Ordering::SeqCst);
        // Whoever found it open still holds the account, or sleeps already and hears the bell.
        drop(self.account());
        self.ring();
        let deadline = Node::now().plus_ns(FAREWELL_NS);
        while self.shared.connections.load(Ordering::SeqCst) > 0 && Node::now() < deadline {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Shared {
    fn account(&self) -> MutexGuard<'_, Chronicle> {
        // A thread that panicked while reading has left the account as it was.
        self.account.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_closing(&self) -> bool {
        self.closing.load(Ordering::SeqCst)
    }

    /// An order goes to the work loop if there is anybody to carry it out.
    fn order(&self, order: Order) -> Result<(), Rejection> {
        let account = self.account();
        let heeds = account.tempo().map(|tempo| tempo.heeds);
        let refusal = match (order, heeds) {
            (Order::HandOver(life), _) if !account.lives().is_live_planner(life) => {
                Some("a hand-over needs a planner that lives")
            }
            (Order::HandOver(_), _) | (_, Some(true)) => None,
            (_, Some(false)) => Some("this order needs a hopper-sim started with --control"),
            (_, None) => Some("hopper-sim has not been heard yet"),
        };
        drop(account);
        if let Some(reason) = refusal {
            return Err(Rejection(409, reason.into()));
        }
        let mut orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        if orders.len() >= ORDERS_MAX {
            return Err(Rejection(503, "too many orders wait already".into()));
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
            // Out of descriptors, say: not a reason to spin.
            std::thread::sleep(Duration::from_millis(10));
            continue;
        };
        let (place, number) = Place::take(shared);
        if number > THREADS_MAX {
            continue;
        }
        let serve = move || {
            if let Err(error) = connection(&stream, &place.0, number > CONNECTIONS_MAX) {
                tracing::debug!("a client of the page is gone: {error}");
            }
        };
        if let Err(error) = std::thread::Builder::new().name("client".into()).spawn(serve) {
            tracing::warn!("a client of the page is turned away: {error}");
        }
    }
}

/// Serves a client; one who comes when it is `full` is only told so.
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
            // What is still under way is read and dropped, or the answer might be lost with it.
            stream.shutdown(std::net::Shutdown::Write)?;
            stream.set_read_timeout(Some(Duration::from_millis(100)))?;
            let mut rest = [0; 1024];
            (0..16).try_for_each(|_| stream.read(&mut rest).map(drop)).or(Ok(()))
        }
    }
}

/// Reads one request, and what it gets.
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

/// Reads on, up to `most` bytes in all.
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
        Ok(0) => Err(Rejection(400, "the request broke off".into())),
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

/// Server-sent events: the account from its beginning, as fast as the client takes it.
fn events(mut stream: &TcpStream, shared: &Shared, policy: bool) -> std::io::Result<()> {
    let counted = policy.then(|| Counted::new(&shared.policies));
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

/// What there is for a reader, up to about [`WRITE_BYTES`].
fn frames(shared: &Shared, cursor: &mut Cursor) -> String {
    let mut text = String::new();
    while text.len() < WRITE_BYTES {
        // The account is let go between two frames: the work loop waits for one at most.
        let Some(Frame { event, data }) = shared.account().next(cursor, Node::now()) else { break };
        text += &format!("event: {event}\ndata: {data}\n\n");
    }
    text
}

/// Sleeps until there may be news; whether there may.
fn wait(shared: &Shared, cursor: &mut Cursor) -> bool {
    let account = shared.account();
    if shared.is_closing() || account.has_news(cursor) {
        return true;
    }
    let woken = shared.bell.wait_timeout(account, IDLE);
    woken.is_ok_and(|(_, timeout)| !timeout.timed_out())
}
