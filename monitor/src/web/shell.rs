//! The page of a mission: its answers to requests, and its event streams, a bounded number of threads.

use std::collections::VecDeque;
use std::io::Write;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use contract::{MonotonicNs, Order};
use node::{Exit, Failure, Node};

use super::gate::{Answer, Gate, HEADERS};
use super::head::Head;
use super::hosts::Hosts;
use super::places::{Kind, PROOF_NS, Places};
use super::reception::{Reception, Served, Service};
use super::redirect_file::RedirectFile;
use super::rejection::Rejection;
use crate::history::{Cursor, Frame};
use crate::{History, Screen, Wish};

/// Most orders that wait for the next turn of the work loop.
const ORDERS_MAX: usize = 64;

/// How long the client of a stream may accept no data before its connection is closed.
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
    /// `None` once the page closes.
    reception: Option<Reception>,
    /// What the browser of this desktop was given instead of the address, if that has a key.
    redirect: Mutex<Option<RedirectFile>>,
}

#[derive(Debug)]
struct Shared {
    history: Arc<Mutex<History>>,
    /// Notified when the history has grown.
    changed: Condvar,
    orders: Mutex<VecDeque<Order>>,
    places: Mutex<Places<Arc<TcpStream>>>,
    closing: AtomicBool,
}

/// A place among the streams, until it is dropped.
struct StreamSlot {
    shared: Arc<Shared>,
    kind: Kind,
    number: u64,
}

impl StreamSlot {
    /// A place, or why there is none. Who makes room for it is disconnected.
    fn take(shared: &Arc<Shared>, kind: Kind) -> Result<Self, Rejection> {
        let (number, displaced) = shared.places().take(kind, Node::now())?;
        if let Some(stream) = displaced {
            // Its thread ends at its next write, also in the midst of one.
            let _ = stream.shutdown(Shutdown::Both);
        }
        Ok(Self { shared: Arc::clone(shared), kind, number })
    }
}

impl Drop for StreamSlot {
    fn drop(&mut self) {
        self.shared.places().leave(self.number);
    }
}

impl Page {
    /// Serves the history at `address`, with orders if `control`, also under the names `hosts`.
    ///
    /// # Errors
    /// If the address cannot be bound.
    pub fn open(
        address: SocketAddr,
        hosts: &[String],
        control: bool,
        history: Arc<Mutex<History>>,
    ) -> Result<Self, Failure> {
        Self::open_for(address, hosts, control, history, PROOF_NS)
    }

    /// Serves streams whose clients have `proof_ns` nanoseconds to show that they read.
    fn open_for(
        address: SocketAddr,
        hosts: &[String],
        control: bool,
        history: Arc<Mutex<History>>,
        proof_ns: u64,
    ) -> Result<Self, Failure> {
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
        if key.is_some() && node::log_is_readable_by_others() {
            tracing::warn!("other users can read this log, which has the key of orders: chmod go-r it");
        }
        if !address.ip().is_loopback() {
            tracing::warn!("anyone who can reach {address} can read the page: nothing on it is encrypted");
        }
        let shared = Arc::new(Shared {
            history,
            changed: Condvar::new(),
            orders: Mutex::default(),
            places: Mutex::new(Places::new(proof_ns)),
            closing: AtomicBool::new(false),
        });
        let gate = Gate::new(Hosts::new(address.ip(), hosts), key);
        let service = PageService { gate, shared: Arc::clone(&shared) };
        let reception = Some(Reception::open("page", listener, service).map_err(unavailable)?);
        Ok(Self { address, url, shared, reception, redirect: Mutex::default() })
    }

    /// Opens the page in the browser of this desktop; that it cannot be opened is a warning. An address with a key is
    /// never an argument, which every user of this machine can read: the browser gets a file that only its owner can read.
    pub fn open_in_browser(&self) {
        let target = if self.url.contains('#') {
            match RedirectFile::write(&self.url) {
                Ok(file) => {
                    let path = file.path().as_os_str().to_owned();
                    *self.redirect.lock().unwrap_or_else(PoisonError::into_inner) = Some(file);
                    path
                }
                Err(error) => {
                    tracing::warn!(
                        "--open: no file for the browser can be written: {error}; open the page yourself"
                    );
                    return;
                }
            }
        } else {
            self.url.clone().into()
        };
        let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
        let quiet = || std::process::Stdio::null();
        let mut command = std::process::Command::new(program);
        if let Err(error) = command.arg(target).stdin(quiet()).stdout(quiet()).stderr(quiet()).spawn() {
            tracing::warn!("--open: {program} cannot be started: {error}; open the page yourself");
        }
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
        self.shared.places().has_policies()
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
        self.reception = None;
        let deadline = Node::now().plus_ns(CLOSE_NS);
        while !self.shared.places().is_empty() && Node::now() < deadline {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Shared {
    fn history(&self) -> MutexGuard<'_, History> {
        // A thread that panicked while reading did not change the history.
        self.history.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn places(&self) -> MutexGuard<'_, Places<Arc<TcpStream>>> {
        self.places.lock().unwrap_or_else(PoisonError::into_inner)
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

/// Answers the requests for the page.
struct PageService {
    gate: Gate,
    shared: Arc<Shared>,
}

impl Service for PageService {
    fn admit(&mut self, head: &Head) -> Result<(), Rejection> {
        self.gate.admit(head)
    }

    fn is_keyed(&self, head: &Head) -> bool {
        self.gate.is_keyed(head)
    }

    fn answer(&mut self, head: &Head, body: &[u8]) -> Result<Served, Rejection> {
        Ok(match self.gate.answer(head, body)? {
            Answer::Asset(asset) => Served::Text("200 OK", asset.kind, asset.text.into()),
            Answer::Reason(cell, at) => {
                let json = self.shared.history().reason_json(cell, at);
                Served::Text("200 OK", "application/json", json.into())
            }
            Answer::Order(order) => {
                self.shared.order(order)?;
                Served::Text("202 Accepted", "text/plain", "accepted\n".into())
            }
            Answer::Reading(place) => {
                self.shared.places().is_read(place);
                Served::Text("200 OK", "text/plain", "noted\n".into())
            }
            Answer::Events(kind) => {
                let slot = StreamSlot::take(&self.shared, kind)?;
                Served::Handed(Box::new(move |stream, _| serve_events(stream, slot)))
            }
        })
    }

    fn headers(&self) -> &'static str {
        HEADERS
    }
}

/// Serves a stream in a thread of its own.
fn serve_events(stream: TcpStream, slot: StreamSlot) {
    let stream = Arc::new(stream);
    if !slot.shared.places().begin(slot.number, Arc::clone(&stream)) {
        return;
    }
    let serve = move || {
        if let Err(error) = events(&stream, slot) {
            tracing::debug!("a client of the page disconnected: {error}");
        }
    };
    if let Err(error) = std::thread::Builder::new().name("client".into()).spawn(serve) {
        tracing::warn!("a client of the page was refused: {error}");
    }
}

/// Sends the number of its place, then the history from its beginning, as server-sent events, as fast as the client reads.
fn events(mut stream: &TcpStream, slot: StreamSlot) -> std::io::Result<()> {
    let StreamSlot { shared, kind, number } = &slot;
    stream.set_write_timeout(Some(STALL))?;
    let head = format!(
        "HTTP/1.1 200 OK\r\n{HEADERS}Content-Type: text/event-stream\r\nConnection: close\r\n\r\nretry: 1000\n\n\
         event: place\ndata: {{\"stream\":{number},\"keyed\":{}}}\n\n",
        kind.keyed
    );
    stream.write_all(head.as_bytes())?;
    let mut cursor = if kind.policy { Cursor::of_policies() } else { Cursor::default() };
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

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::super::places::HISTORIES_MAX;
    use super::*;

    fn ask(address: SocketAddr, path: &str) -> (TcpStream, String) {
        let mut stream = TcpStream::connect(address).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        (stream, String::from_utf8(status.into()).unwrap())
    }

    /// The number of the place of a stream, as its page reads it.
    fn place(stream: &mut TcpStream) -> String {
        let (mut text, mut byte) = (Vec::new(), [0]);
        while !text.ends_with(b"}\n\n") {
            stream.read_exact(&mut byte).unwrap();
            text.push(byte[0]);
        }
        let text = String::from_utf8(text).unwrap();
        text.split_once("\"stream\":").unwrap().1.split_once(',').unwrap().0.to_owned()
    }

    /// P-WEB-DEAF. Clients that read no event keep nobody out, with or without `--control`; a page
    /// that reads keeps its slot.
    #[test]
    fn streams_that_nobody_reads_make_room() {
        for control in [false, true] {
            let history = Arc::new(Mutex::new(History::new(contract::RobotId(0))));
            let page = Page::open_for("127.0.0.1:0".parse().unwrap(), &[], control, history, 0).unwrap();
            let address = page.address();
            let (mut reader, _) = ask(address, "/events");
            let number = place(&mut reader);
            assert_eq!(ask(address, &format!("/reading?stream={number}")).1, "HTTP/1.1 200");
            let mut deaf: Vec<_> = (1..HISTORIES_MAX).map(|_| ask(address, "/events").0).collect();
            for _ in 0..3 * HISTORIES_MAX {
                let (stream, status) = ask(address, "/events");
                assert_eq!(status, "HTTP/1.1 200");
                deaf.push(stream);
            }
            let mut rest = Vec::new();
            deaf[0].read_to_end(&mut rest).unwrap();
            assert!(rest.ends_with(b"\n\n"), "the first has made room");
            reader.read_exact(&mut [0; 6]).unwrap();
            while Arc::strong_count(&page.shared) > 2 + HISTORIES_MAX {
                std::thread::sleep(Duration::from_millis(5));
            }
        }
    }
}
