//! Accepts connections and reads one request from each, in one thread.
//!
//! A connection that is slow to send or to read holds a place here, and no thread. When all places are taken, a new
//! connection gets that of the one that came first of those without the key, so whoever sends a whole request at once is
//! answered, however many others send nothing. Answers that last, as event streams, are handed over with their socket.

use std::borrow::Cow;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use contract::MonotonicNs;
use node::Node;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::head::{HEAD_BYTES_MAX, Head};
use super::rejection::{RefusalLog, Rejection};

/// Most connections whose request is read, or answered in short, at the same time.
pub const GUESTS_MAX: usize = 128;

/// How long a request may take to arrive, and its answer to be taken, nanoseconds each.
const ARRIVAL_NS: u64 = 5_000_000_000;
const TAKING_NS: u64 = 10_000_000_000;

/// How long input is still read and dropped after an answer, nanoseconds: closing with unread data could discard the answer.
const DRAIN_NS: u64 = 500_000_000;

/// Most connections that are accepted before those that are there are looked at again.
const ACCEPTED_MAX: usize = 16;

/// Pause after the operating system has refused a connection, nanoseconds: for example, it is out of descriptors.
const REFUSED_NS: u64 = 20_000_000;

/// How long answers that are being written may go on once the server closes, nanoseconds.
const CLOSE_NS: u64 = 300_000_000;

/// What a server does with requests.
pub trait Service: Send + 'static {
    /// Checks the head of a request, before its body is read.
    ///
    /// # Errors
    /// Why the request is refused.
    fn admit(&mut self, head: &Head) -> Result<(), Rejection>;

    /// Whether an admitted request has the key: its place is not given to another.
    fn is_keyed(&self, head: &Head) -> bool;

    /// The answer to an admitted request.
    ///
    /// # Errors
    /// Why the request is refused.
    fn answer(&mut self, head: &Head, body: &[u8]) -> Result<Served, Rejection>;

    /// Headers of every response, each with its line end.
    fn headers(&self) -> &'static str;
}

/// Takes over a socket, which blocks, and what was already read after the request.
pub type Take = Box<dyn FnOnce(TcpStream, Vec<u8>) + Send>;

/// How a request is answered.
pub enum Served {
    /// Status, content type and text.
    Text(&'static str, &'static str, Cow<'static, str>),
    /// By whoever takes the socket.
    Handed(Take),
}

/// A thread that receives. Dropping it ends the thread.
#[derive(Debug)]
pub struct Reception {
    thread: Option<JoinHandle<()>>,
    closing: Arc<AtomicBool>,
    wake: UnixStream,
}

impl Reception {
    /// Begins to receive at `listener`; `name` is for the log.
    ///
    /// # Errors
    /// If the operating system refuses a thread or a descriptor.
    pub fn open(name: &'static str, listener: TcpListener, service: impl Service) -> std::io::Result<Self> {
        Self::open_for(name, listener, service, ARRIVAL_NS)
    }

    /// Receives requests that may take `arrival_ns` to arrive.
    fn open_for(
        name: &'static str,
        listener: TcpListener,
        service: impl Service,
        arrival_ns: u64,
    ) -> std::io::Result<Self> {
        listener.set_nonblocking(true)?;
        let (wake, woken) = UnixStream::pair()?;
        woken.set_nonblocking(true)?;
        let closing = Arc::new(AtomicBool::new(false));
        let mut desk = Desk {
            name,
            listener,
            woken,
            closing: Arc::clone(&closing),
            service,
            arrival_ns,
            guests: Vec::new(),
            refusals: RefusalLog::default(),
            paused_until: MonotonicNs(0),
        };
        let thread = std::thread::Builder::new().name(name.into()).spawn(move || desk.run())?;
        Ok(Self { thread: Some(thread), closing, wake })
    }
}

impl Drop for Reception {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::SeqCst);
        // The other end is in the thread; if that is gone, nobody needs to be woken.
        let _ = self.wake.write(&[1]);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A connection with its request.
struct Guest {
    stream: TcpStream,
    keyed: bool,
    stage: Stage,
    /// When the stage ends, whatever has come.
    deadline: MonotonicNs,
}

enum Stage {
    /// The request is read; its head, once it is whole and admitted, with its length.
    Reading(Vec<u8>, Option<(Head, usize)>),
    /// The answer is written: head, text, how much of both is sent.
    Writing(Vec<u8>, Cow<'static, str>, usize),
    /// The answer is sent; input is dropped until the client closes.
    Draining,
}

/// What becomes of a guest.
enum Next {
    Stays,
    Leaves,
    Handed(Take, Vec<u8>),
}

struct Desk<S> {
    name: &'static str,
    listener: TcpListener,
    woken: UnixStream,
    closing: Arc<AtomicBool>,
    service: S,
    /// How long a request may take to arrive, nanoseconds.
    arrival_ns: u64,
    /// In the order in which they came.
    guests: Vec<Guest>,
    refusals: RefusalLog,
    /// No connection is accepted until then.
    paused_until: MonotonicNs,
}

impl<S: Service> Desk<S> {
    fn run(&mut self) {
        while !self.closing.load(Ordering::SeqCst) {
            self.wait(true);
            self.turn(Node::now());
            if Node::now() >= self.paused_until {
                self.accept();
            }
        }
        let deadline = Node::now().plus_ns(CLOSE_NS);
        loop {
            self.guests.retain(|guest| matches!(guest.stage, Stage::Writing(..)));
            if self.guests.is_empty() || Node::now() >= deadline {
                return;
            }
            self.guests.iter_mut().for_each(|guest| guest.deadline = guest.deadline.min(deadline));
            self.wait(false);
            self.turn(Node::now());
        }
    }

    /// Waits until a socket is ready, a deadline has passed or the server closes.
    fn wait(&mut self, accepts: bool) {
        let now = Node::now();
        let is_paused = now < self.paused_until;
        let paused = is_paused.then_some(self.paused_until);
        let next = self.guests.iter().map(|guest| guest.deadline).chain(paused).min();
        let timeout = next
            .map(|next| next.since_ns(now))
            .map(|ns| Timespec { tv_sec: (ns / 1_000_000_000) as i64, tv_nsec: (ns % 1_000_000_000) as _ });
        let mut sockets = Vec::with_capacity(self.guests.len() + 2);
        if accepts {
            sockets.push(PollFd::new(&self.woken, PollFlags::IN));
            if !is_paused {
                sockets.push(PollFd::new(&self.listener, PollFlags::IN));
            }
        }
        sockets.extend(self.guests.iter().map(|guest| PollFd::from_borrowed_fd(guest.fd(), guest.events())));
        // A signal ends the wait early, which does no harm.
        let _ = poll(&mut sockets, timeout.as_ref());
    }

    /// Lets every guest go on as far as its socket allows.
    fn turn(&mut self, now: MonotonicNs) {
        for mut guest in std::mem::take(&mut self.guests) {
            match self.advance(&mut guest, now) {
                Next::Stays => self.guests.push(guest),
                Next::Leaves => {}
                Next::Handed(take, rest) => self.hand_over(guest.stream, take, rest),
            }
        }
    }

    fn accept(&mut self) {
        for _ in 0..ACCEPTED_MAX {
            let stream = match self.listener.accept() {
                Ok((stream, _)) => stream,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) if error.kind() == ErrorKind::ConnectionAborted => continue,
                Err(error) => {
                    tracing::debug!("{}: a connection is not accepted: {error}", self.name);
                    self.dismiss_one();
                    self.paused_until = Node::now().plus_ns(REFUSED_NS);
                    return;
                }
            };
            if stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).is_err() {
                continue;
            }
            if self.guests.len() >= GUESTS_MAX {
                self.dismiss_one();
            }
            let now = Node::now();
            let deadline = now.plus_ns(self.arrival_ns);
            let mut guest = Guest { stream, keyed: false, stage: Stage::Reading(Vec::new(), None), deadline };
            // Mostly the request is there already.
            match self.advance(&mut guest, now) {
                Next::Stays => self.guests.push(guest),
                Next::Leaves => {}
                Next::Handed(take, rest) => self.hand_over(guest.stream, take, rest),
            }
        }
    }

    /// Closes the connection that came first of those that wait for nothing but their client; one with the key only if all
    /// have it.
    fn dismiss_one(&mut self) {
        let drains = |guest: &Guest| matches!(guest.stage, Stage::Draining);
        let place = self
            .guests
            .iter()
            .position(drains)
            .or_else(|| self.guests.iter().position(|guest| !guest.keyed))
            .unwrap_or(0);
        if place < self.guests.len() {
            self.guests.remove(place);
        }
    }

    fn hand_over(&self, stream: TcpStream, take: Take, rest: Vec<u8>) {
        match stream.set_nonblocking(false) {
            Ok(()) => take(stream, rest),
            Err(error) => tracing::debug!("{}: a client is gone: {error}", self.name),
        }
    }

    fn advance(&mut self, guest: &mut Guest, now: MonotonicNs) -> Next {
        loop {
            let stage = std::mem::replace(&mut guest.stage, Stage::Draining);
            let (stage, goes_on) = match stage {
                Stage::Reading(bytes, head) => match self.read(guest, bytes, head, now) {
                    Ok(Some(Reply::Handed(take, rest))) => return Next::Handed(take, rest),
                    Ok(Some(Reply::Later(bytes, head))) => (Stage::Reading(bytes, head), false),
                    Ok(Some(Reply::Now(stage))) => {
                        guest.deadline = now.plus_ns(TAKING_NS);
                        (stage, true)
                    }
                    Ok(None) => return Next::Leaves,
                    Err(rejection) => {
                        guest.deadline = now.plus_ns(TAKING_NS);
                        (self.refuse(&rejection), true)
                    }
                },
                Stage::Writing(..) if now >= guest.deadline => return Next::Leaves,
                Stage::Writing(head, text, sent) => match write(&guest.stream, &head, &text, sent) {
                    Ok(sent) if sent == head.len() + text.len() => {
                        if guest.stream.shutdown(Shutdown::Write).is_err() {
                            return Next::Leaves;
                        }
                        guest.deadline = now.plus_ns(DRAIN_NS);
                        (Stage::Draining, true)
                    }
                    Ok(sent) => (Stage::Writing(head, text, sent), false),
                    Err(_) => return Next::Leaves,
                },
                Stage::Draining if now >= guest.deadline => return Next::Leaves,
                Stage::Draining => match drain(&guest.stream) {
                    true => (Stage::Draining, false),
                    false => return Next::Leaves,
                },
            };
            guest.stage = stage;
            if !goes_on {
                return Next::Stays;
            }
        }
    }

    /// Reads what has come; the reply once the request is whole, `None` if the client is gone.
    fn read(
        &mut self,
        guest: &mut Guest,
        mut bytes: Vec<u8>,
        mut head: Option<(Head, usize)>,
        now: MonotonicNs,
    ) -> Result<Option<Reply>, Rejection> {
        loop {
            if head.is_none()
                && let Some((parsed, size)) = Head::parse(&bytes)?
            {
                self.service.admit(&parsed)?;
                guest.keyed = self.service.is_keyed(&parsed);
                head = Some((parsed, size));
            }
            let most = head.as_ref().map_or(HEAD_BYTES_MAX, |(head, size)| size + head.length);
            if let Some((head, size)) = &head
                && bytes.len() >= most
            {
                let served = self.service.answer(head, &bytes[*size..most])?;
                return Ok(Some(match served {
                    Served::Handed(take) => Reply::Handed(take, bytes.split_off(most)),
                    Served::Text(status, kind, text) => Reply::Now(self.respond(status, kind, text)),
                }));
            }
            if now >= guest.deadline {
                return Err(Rejection::new(408, "the request took too long to arrive"));
            }
            let mut piece = [0; 2048];
            let room = piece.len().min(most - bytes.len());
            match (&guest.stream).read(&mut piece[..room]) {
                Ok(0) if bytes.is_empty() => return Ok(None),
                Ok(0) => return Err(Rejection::new(400, "the request was cut short")),
                Ok(count) => bytes.extend_from_slice(&piece[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    return Ok(Some(Reply::Later(bytes, head)));
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Ok(None),
            }
        }
    }

    fn respond(&self, status: &str, kind: &str, text: Cow<'static, str>) -> Stage {
        let head = format!(
            "HTTP/1.1 {status}\r\n{}Content-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
            self.service.headers(),
            text.len()
        );
        Stage::Writing(head.into_bytes(), text, 0)
    }

    fn refuse(&mut self, rejection: &Rejection) -> Stage {
        if let Some(line) = self.refusals.line(rejection) {
            tracing::warn!("{}: {line}", self.name);
        }
        let status = format!("{} {}", rejection.0, rejection.phrase());
        tracing::debug!(status, "{}: refused a request: {}", self.name, rejection.1);
        self.respond(&status, "text/plain; charset=utf-8", format!("{}\n", rejection.1).into())
    }
}

/// What a read has led to.
enum Reply {
    /// The request is not whole.
    Later(Vec<u8>, Option<(Head, usize)>),
    Now(Stage),
    Handed(Take, Vec<u8>),
}

impl Guest {
    fn fd(&self) -> BorrowedFd<'_> {
        self.stream.as_fd()
    }

    fn events(&self) -> PollFlags {
        match self.stage {
            Stage::Writing(..) => PollFlags::OUT,
            Stage::Reading(..) | Stage::Draining => PollFlags::IN,
        }
    }
}

/// Writes as much of an answer as the socket takes; how much is sent then.
fn write(mut stream: &TcpStream, head: &[u8], text: &str, mut sent: usize) -> std::io::Result<usize> {
    loop {
        let rest = match sent.checked_sub(head.len()) {
            None => &head[sent..],
            Some(of_text) => &text.as_bytes()[of_text..],
        };
        if rest.is_empty() {
            return Ok(sent);
        }
        match stream.write(rest) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(count) => sent += count,
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(sent),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// Drops what has come, of one look at most 64 KiB; whether the client may send more.
fn drain(mut stream: &TcpStream) -> bool {
    let mut rest = [0; 4096];
    for _ in 0..16 {
        match stream.read(&mut rest) {
            Ok(0) => return false,
            Ok(_) => {}
            Err(error) => return matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted),
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers every request with its path.
    struct Echo;

    impl Service for Echo {
        fn admit(&mut self, head: &Head) -> Result<(), Rejection> {
            if head.path == "/no" { Err(Rejection::new(404, "there is no such path")) } else { Ok(()) }
        }

        fn is_keyed(&self, head: &Head) -> bool {
            head.header("x-hopper-key").is_some()
        }

        fn answer(&mut self, head: &Head, body: &[u8]) -> Result<Served, Rejection> {
            let body = String::from_utf8_lossy(body).into_owned();
            Ok(Served::Text("200 OK", "text/plain", format!("{}{body}", head.path).into()))
        }

        fn headers(&self) -> &'static str {
            ""
        }
    }

    /// An hour, so that a slow machine gives up no request.
    const HOUR_NS: u64 = 3_600_000_000_000;

    fn open(arrival_ns: u64) -> (Reception, std::net::SocketAddr) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        (Reception::open_for("echo", listener, Echo, arrival_ns).unwrap(), address)
    }

    fn ask(address: std::net::SocketAddr, request: &str) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    #[test]
    fn a_request_is_answered_once_it_is_whole() {
        let (reception, address) = open(HOUR_NS);
        let answer = ask(address, "POST /a HTTP/1.1\r\nContent-Length: 2\r\n\r\nxyz");
        assert!(answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with("\r\n\r\n/axy"), "{answer}");
        assert!(ask(address, "GET /no HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404 Not Found\r\n"));
        assert!(ask(address, "nonsense\r\n\r\n").starts_with("HTTP/1.1 400 "));
        let mut cut = TcpStream::connect(address).unwrap();
        cut.write_all(b"GET /a").unwrap();
        cut.shutdown(Shutdown::Write).unwrap();
        let mut answer = String::new();
        cut.read_to_string(&mut answer).unwrap();
        assert!(answer.contains("cut short"), "{answer}");
        drop(reception);
        assert!(TcpStream::connect(address).is_err(), "nobody listens any more");
    }

    /// P-FOXGLOVE-SILENT. A request that does not arrive in time gets an error, and its socket is
    /// closed.
    #[test]
    fn a_request_that_does_not_arrive_is_given_up() {
        let (_reception, address) = open(20_000_000);
        for sent in ["", "GET /a HTTP/1.1\r\n", "POST /a HTTP/1.1\r\nContent-Length: 9\r\n\r\nx"] {
            assert!(ask(address, sent).starts_with("HTTP/1.1 408 "), "{sent:?}");
        }
    }

    /// P-WEB-SLOW-REQUESTS. Slots are bounded; the oldest client without the key makes room.
    #[test]
    fn slow_clients_are_bounded_and_keep_nobody_out() {
        let (_reception, address) = open(HOUR_NS);
        let mut keyed = TcpStream::connect(address).unwrap();
        keyed.write_all(b"POST /k HTTP/1.1\r\nX-Hopper-Key: 1\r\nContent-Length: 1\r\n\r\n").unwrap();
        // Its head is read before the others come.
        assert!(ask(address, "GET /a HTTP/1.1\r\n\r\n").ends_with("/a"));
        let mut slow = Vec::new();
        for number in 0..2 * GUESTS_MAX {
            slow.push(TcpStream::connect(address).unwrap());
            if number % 16 == 0 {
                assert!(ask(address, "GET /a HTTP/1.1\r\n\r\n").ends_with("/a"), "{number}");
            }
        }
        let mut closed = [0];
        assert!(matches!(slow[0].read(&mut closed), Ok(0) | Err(_)), "the first has made room");
        keyed.write_all(b"x").unwrap();
        let mut answer = String::new();
        keyed.read_to_string(&mut answer).unwrap();
        assert!(answer.ends_with("/kx"), "{answer}");
    }
}
