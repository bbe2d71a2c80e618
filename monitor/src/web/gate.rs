//! Decides which requests are served and which are refused.
//!
//! Every page in the user's browser can reach a server on loopback, so requests are not trusted. The Host header must
//! be an address of this machine (a name could be rebound by its owner), the path must be known, and an order must come
//! from this page with the key that only the log of the monitor shows.

// Addresses, but no sockets.
use core::net::{IpAddr, SocketAddr};

use contract::{Cell, Decision, Order};

use super::asset::{Asset, asset};
use super::order::order;

/// Most bytes of request line and headers.
pub const HEAD_BYTES_MAX: usize = 8 << 10;

/// Most headers of a request.
pub const HEADERS_MAX: usize = 64;

/// Most bytes of an order.
pub const BODY_BYTES_MAX: usize = 512;

/// Paths of the event streams: history, policies.
const STREAMS: [&str; 2] = ["/events", "/policy"];

/// Path of the reason for a hop: `/why?x=3&y=4&at=17`.
const WHY: &str = "/why";

/// Headers of every response: no foreign content, no embedding in frames, no guessing of types.
pub const HEADERS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
    X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Opener-Policy: same-origin\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\n";

/// The rules for requests to one page.
#[derive(Clone, Debug)]
pub struct Gate {
    /// Address the page is served at.
    address: SocketAddr,
    /// Key that orders must have; `None` if orders are not allowed.
    key: Option<String>,
}

/// How to answer a request that is served.
#[derive(Clone, Debug)]
pub enum Answer {
    /// With a file.
    Asset(&'static Asset),
    /// The history, frame by frame, or the policies alone.
    Events {
        /// Whether policies are requested instead of the history.
        policy: bool,
        /// Whether the request has the key that orders need, so that it may use a place kept free for it.
        keyed: bool,
    },
    /// With the reason for a hop from a cell when a decision is due.
    Reason(Cell, Decision),
    /// By passing on an order.
    Order(Order),
}

/// Why a request is refused: the HTTP status code and a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejection(pub u16, pub String);

/// Request line and headers, as far as they are used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Head {
    method: String,
    path: String,
    query: String,
    host: Option<String>,
    origin: Option<String>,
    site: Option<String>,
    kind: Option<String>,
    key: Option<String>,
    /// Length of the body, bytes.
    pub length: usize,
    /// Whether the length is stated.
    has_length: bool,
}

impl Rejection {
    fn new(status: u16, reason: impl Into<String>) -> Self {
        Self(status, reason.into())
    }

    /// The reason phrase of the status code.
    #[must_use]
    pub fn phrase(&self) -> &'static str {
        match self.0 {
            400 => "Bad Request",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            408 => "Request Timeout",
            409 => "Conflict",
            411 => "Length Required",
            413 => "Content Too Large",
            415 => "Unsupported Media Type",
            421 => "Misdirected Request",
            431 => "Request Header Fields Too Large",
            503 => "Service Unavailable",
            _ => "Error",
        }
    }
}

impl Head {
    /// Parses the head at the beginning of `bytes`; returns it with its length in bytes, or `None` if it is incomplete.
    ///
    /// # Errors
    /// If it is not HTTP/1.1, repeats a header, or is too long.
    pub fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, Rejection> {
        let too_long =
            || Rejection::new(431, format!("a request needs at most {HEAD_BYTES_MAX} bytes of head"));
        let mut headers = [httparse::EMPTY_HEADER; HEADERS_MAX];
        let mut request = httparse::Request::new(&mut headers);
        let size = match request.parse(bytes) {
            Ok(httparse::Status::Complete(size)) if size > HEAD_BYTES_MAX => return Err(too_long()),
            Ok(httparse::Status::Complete(size)) => size,
            Ok(httparse::Status::Partial) if bytes.len() >= HEAD_BYTES_MAX => return Err(too_long()),
            Ok(httparse::Status::Partial) => return Ok(None),
            Err(httparse::Error::TooManyHeaders) => return Err(too_long()),
            Err(error) => {
                return Err(Rejection::new(400, format!("a request needs to be HTTP/1.1: {error}")));
            }
        };
        let target = request.path.unwrap_or_default();
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let mut head = Self {
            method: request.method.unwrap_or_default().into(),
            path: path.into(),
            query: query.into(),
            ..Self::default()
        };
        for header in request.headers.iter() {
            head.take(header.name, header.value)?;
        }
        Ok(Some((head, size)))
    }

    fn take(&mut self, name: &str, value: &[u8]) -> Result<(), Rejection> {
        let text = || {
            let text = std::str::from_utf8(value).ok().filter(|text| text.is_ascii());
            text.map(|text| text.trim().to_owned()).ok_or_else(|| Rejection::new(400, "a header needs ASCII"))
        };
        let field = match name.to_ascii_lowercase().as_str() {
            "host" => &mut self.host,
            "origin" => &mut self.origin,
            "sec-fetch-site" => &mut self.site,
            "content-type" => &mut self.kind,
            "x-hopper-key" => &mut self.key,
            "transfer-encoding" => return Err(Rejection::new(411, "an order needs a Content-Length")),
            "content-length" if self.has_length => {
                return Err(Rejection::new(400, "header Content-Length came twice"));
            }
            "content-length" => {
                self.has_length = true;
                let length = text()?;
                let digits = length.bytes().all(|byte| byte.is_ascii_digit()) && !length.is_empty();
                let number = length.parse().ok().filter(|_| digits && length.len() < 10);
                self.length = number.ok_or_else(|| Rejection::new(413, "a body needs a length in digits"))?;
                return Ok(());
            }
            _ => return Ok(()),
        };
        if field.is_some() {
            return Err(Rejection::new(400, format!("header {name} came twice")));
        }
        *field = Some(text()?);
        Ok(())
    }
}

impl Gate {
    /// The rules of a page at `address`; orders need `key`, and are refused without one.
    #[must_use]
    pub fn new(address: SocketAddr, key: Option<String>) -> Self {
        Self { address, key }
    }

    /// Checks the head of a request, before its body is read.
    ///
    /// # Errors
    /// Why the request is refused.
    pub fn admit(&self, head: &Head) -> Result<(), Rejection> {
        let host = head.host.as_deref().unwrap_or_default();
        if !self.is_ours(host) {
            return Err(Rejection::new(421, format!("this is {}, not {host:?}", self.address)));
        }
        if head.site.as_deref().is_some_and(|site| !matches!(site, "same-origin" | "none")) {
            return Err(Rejection::new(403, "requests need to come from this page"));
        }
        match head.method.as_str() {
            "GET" if head.path == "/control" => Err(Rejection::new(405, "an order needs POST")),
            "GET" if head.path == WHY && head.length == 0 => reason(&head.query).map(drop),
            "GET" if !STREAMS.contains(&head.path.as_str()) && asset(&head.path).is_none() => {
                Err(Rejection::new(404, "there is no such path"))
            }
            "GET" if head.length > 0 => Err(Rejection::new(413, "GET needs no body")),
            "GET" => Ok(()),
            "POST" if head.path == "/control" => self.admit_order(head, host),
            "POST" => Err(Rejection::new(405, "only orders are posted")),
            _ => Err(Rejection::new(405, "the method needs to be GET, or POST for orders")),
        }
    }

    fn admit_order(&self, head: &Head, host: &str) -> Result<(), Rejection> {
        let Some(key) = &self.key else {
            return Err(Rejection::new(403, "orders need a monitor started with --control"));
        };
        if head.origin.as_deref().is_none_or(|origin| origin.strip_prefix("http://") != Some(host)) {
            return Err(Rejection::new(403, "orders need to come from this page"));
        }
        if head.key.as_deref().is_none_or(|given| !same(given.as_bytes(), key.as_bytes())) {
            return Err(Rejection::new(403, "orders need the key of the address that the monitor printed"));
        }
        if head.kind.as_deref() != Some("application/json") {
            return Err(Rejection::new(415, "an order needs to be application/json"));
        }
        if head.length == 0 || head.length > BODY_BYTES_MAX {
            return Err(Rejection::new(413, format!("an order needs 1 to {BODY_BYTES_MAX} bytes")));
        }
        Ok(())
    }

    /// The answer to a request, once its body is read.
    ///
    /// # Errors
    /// If it is not admitted, or its body is not an order.
    pub fn answer(&self, head: &Head, body: &[u8]) -> Result<Answer, Rejection> {
        self.admit(head)?;
        if head.method == "POST" {
            return order(body).map(Answer::Order).map_err(|reason| Rejection::new(400, reason));
        }
        if STREAMS.contains(&head.path.as_str()) {
            let given = head.query.split('&').find_map(|part| part.strip_prefix("key="));
            let keyed = self
                .key
                .as_deref()
                .zip(given)
                .is_some_and(|(key, given)| same(given.as_bytes(), key.as_bytes()));
            return Ok(Answer::Events { policy: head.path == STREAMS[1], keyed });
        }
        if head.path == WHY {
            return reason(&head.query);
        }
        asset(&head.path).map(Answer::Asset).ok_or_else(|| Rejection::new(404, "there is no such path"))
    }

    /// Whether a Host header names this page: our port, with localhost or one of our addresses. Any other name may
    /// belong to somebody else, whatever it resolves to.
    fn is_ours(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.ends_with(']') => (name, port),
            _ => (host, "80"),
        };
        if port != self.address.port().to_string() {
            return false;
        }
        if name.eq_ignore_ascii_case("localhost") {
            return true;
        }
        let literal = name.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(name);
        let ours = self.address.ip();
        literal.parse::<IpAddr>().is_ok_and(|ip| ip == ours || ip.is_loopback() || ours.is_unspecified())
    }
}

/// The cell and the decision that `x=3&y=4&at=17` asks about; each once, in digits.
fn reason(query: &str) -> Result<Answer, Rejection> {
    let need =
        || Rejection::new(400, format!("{WHY} needs x, y and at in digits, as in {WHY}?x=3&y=4&at=17"));
    let field = |name: &str| {
        let mut values = query.split('&').filter_map(|part| part.split_once('='));
        let digits = |text: &&str| text.len() <= 15 && text.bytes().all(|byte| byte.is_ascii_digit());
        let value = values.find(|(key, _)| *key == name).map(|(_, value)| value).filter(digits);
        value.and_then(|value| value.parse::<u64>().ok()).ok_or_else(need)
    };
    let side = |name: &str| i32::try_from(field(name)?).map_err(|_| need());
    Ok(Answer::Reason(Cell::new(side("x")?, side("y")?), Decision(field("at")?)))
}

/// Whether two keys are equal, compared in constant time.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |differences, (a, b)| differences | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &str = "0123456789abcdef";

    fn gate(address: &str, key: Option<&str>) -> Gate {
        Gate::new(address.parse().unwrap(), key.map(Into::into))
    }

    fn ask(gate: &Gate, head: &str, body: &str) -> Result<Answer, Rejection> {
        let text = format!("{}\r\n\r\n", head.trim().replace('\n', "\r\n"));
        let (head, size) = Head::parse(text.as_bytes())?.expect("a whole head");
        assert_eq!(size, text.len());
        gate.answer(&head, body.as_bytes())
    }

    fn status(gate: &Gate, head: &str, body: &str) -> u16 {
        ask(gate, head, body).err().map_or(200, |rejection| rejection.0)
    }

    /// P-WEB-GATE: only known paths, hosts and methods get anything.
    #[test]
    fn only_known_paths_hosts_and_methods_get_anything() {
        let gate = gate("127.0.0.1:8427", None);
        let get = |path: &str, host: &str| status(&gate, &format!("GET {path} HTTP/1.1\nHost: {host}"), "");
        for host in ["127.0.0.1:8427", "localhost:8427", "LOCALHOST:8427", "[::1]:8427"] {
            assert_eq!(get("/", host), 200, "{host}");
        }
        for host in [
            "",
            "evil.example",
            "evil.example:8427",
            "127.0.0.1",
            "127.0.0.1:80",
            "127.0.0.1:84270",
            "localhost.evil.example:8427",
            "10.0.0.1:8427",
            "[::2]:8427",
            "127.0.0.1:8427@evil.example",
            "0x7f.1:8427",
        ] {
            assert_eq!(get("/", host), 421, "{host:?}");
        }
        assert_eq!(status(&gate, "GET / HTTP/1.1\nAccept: */*", ""), 421, "no host at all");
        assert_eq!((get("/events", "localhost:8427"), get("/policy", "localhost:8427")), (200, 200));
        for path in [
            "/x",
            "//",
            "/../etc/passwd",
            "/%2e%2e/x",
            "/page.css/",
            "/PAGE.CSS",
            "*",
            "http://localhost:8427/",
        ] {
            assert_eq!(get(path, "localhost:8427"), 404, "{path}");
        }
        for method in ["HEAD", "PUT", "DELETE", "OPTIONS", "TRACE", "POST", "BREW"] {
            assert_eq!(
                status(&gate, &format!("{method} / HTTP/1.1\nHost: localhost:8427"), ""),
                405,
                "{method}"
            );
        }
        let site = |site: &str| {
            status(&gate, &format!("GET / HTTP/1.1\nHost: localhost:8427\nSec-Fetch-Site: {site}"), "")
        };
        assert_eq!(
            [site("none"), site("same-origin"), site("cross-site"), site("same-site")],
            [200, 200, 403, 403]
        );
        let wide = super::tests::gate("0.0.0.0:8427", None);
        assert_eq!(status(&wide, "GET / HTTP/1.1\nHost: 192.168.7.9:8427", ""), 200, "asked for everywhere");
        assert_eq!(status(&wide, "GET / HTTP/1.1\nHost: evil.example:8427", ""), 421);
    }

    const ORDER: &str = "POST /control HTTP/1.1\nHost: localhost:8427\nOrigin: http://localhost:8427\n\
        Content-Type: application/json\nContent-Length: 17\nX-Hopper-Key: 0123456789abcdef";
    const PAUSE: &str = r#"{"order":"pause"}"#;

    /// P-WEB-CONTROL: an order needs leave, this page, the key, and a form.
    #[test]
    fn an_order_needs_leave_and_this_page_and_the_key_and_a_form() {
        assert_eq!(status(&gate("127.0.0.1:8427", None), ORDER, PAUSE), 403, "without --control");
        let gate = gate("127.0.0.1:8427", Some(KEY));
        assert!(matches!(ask(&gate, ORDER, PAUSE), Ok(Answer::Order(Order::Pause))));
        for (what, with, need) in [
            ("Origin: http://localhost:8427", "Origin: http://evil.example", 403),
            ("Origin: http://localhost:8427", "Origin: null", 403),
            ("Origin: http://localhost:8427", "Origin: https://localhost:8427", 403),
            ("Origin: http://localhost:8427", "Via: x", 403),
            (KEY, "0123456789abcdee", 403),
            (KEY, "", 403),
            ("application/json", "text/plain", 415),
            ("Content-Length: 17", "Content-Length: 0", 413),
            ("Content-Length: 17", "Content-Length: 513", 413),
            ("Content-Length: 17", "Content-Length: -1", 413),
            ("Content-Length: 17", "Content-Length: 99999999999999999999", 413),
            ("Content-Length: 17", "Transfer-Encoding: chunked", 411),
            ("POST", "GET", 405),
            ("Origin: http://localhost:8427", "Host: localhost:8427", 400),
            ("Content-Length: 17", "Content-Length: 17\nContent-Length: 17", 400),
            ("Content-Length: 17", "Content-Length: 0\ncontent-length: 17", 400),
            ("Content-Length: 17", "Content-Length: 17, 17", 413),
        ] {
            assert_eq!(status(&gate, &ORDER.replace(what, with), PAUSE), need, "{with}");
        }
        assert_eq!(status(&gate, ORDER, "not an order"), 400);
    }

    #[test]
    fn a_stream_with_the_key_is_told_from_one_without() {
        let keyed = |gate: &Gate, query: &str| {
            let head = format!("GET /events{query} HTTP/1.1\nHost: localhost:8427");
            let Ok(Answer::Events { policy: false, keyed }) = ask(gate, &head, "") else {
                panic!("no stream")
            };
            keyed
        };
        let with_key = gate("127.0.0.1:8427", Some(KEY));
        assert!(keyed(&with_key, &format!("?key={KEY}")) && keyed(&with_key, &format!("?x&key={KEY}")));
        for query in ["", "?key=", "?key=0", "?0123456789abcdef"] {
            assert!(!keyed(&with_key, query), "{query}");
        }
        assert!(!keyed(&gate("127.0.0.1:8427", None), &format!("?key={KEY}")));
    }

    #[test]
    fn a_head_is_read_byte_by_byte_and_bounded() {
        let text = "GET /events?x=1 HTTP/1.1\r\nHost: localhost:1\r\n\r\n";
        for cut in 0..text.len() {
            assert_eq!(Head::parse(&text.as_bytes()[..cut]), Ok(None), "{cut}");
        }
        let (head, size) = Head::parse(text.as_bytes()).unwrap().unwrap();
        assert_eq!((head.query.as_str(), size), ("x=1", text.len()));
        let long = format!("GET /{} HTTP/1.1\r\n", "x".repeat(HEAD_BYTES_MAX));
        assert_eq!(Head::parse(long.as_bytes()).unwrap_err().0, 431);
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(HEADERS_MAX + 1));
        assert_eq!(Head::parse(many.as_bytes()).unwrap_err().0, 431);
        for garbage in
            ["\u{16}\u{3}\u{1}", "GET  / HTTP/1.1\r\n\r\n", "GET / HTTP/1.1\r\nHost x\r\n\r\n", "\0\0\0\0"]
        {
            assert_eq!(Head::parse(garbage.as_bytes()).unwrap_err().0, 400, "{garbage:?}");
        }
    }
}
