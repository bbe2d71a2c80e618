//! Decides which requests are served and which are refused.
//!
//! Every page in the user's browser can reach a server on loopback, so requests are not trusted. The Host header must
//! be a name of this server ([`Hosts`]), the path must be known, a request that another page makes must only open this one,
//! and an order must come from this page with the key that only the log of the monitor shows.

use contract::{Cell, Decision, Order};

use super::asset::{Asset, asset};
use super::head::Head;
use super::hosts::Hosts;
use super::order::order;
use super::places::Kind;
use super::rejection::Rejection;

/// Most bytes of an order.
pub const BODY_BYTES_MAX: usize = 512;

/// Paths of the event streams: history, policies.
const STREAMS: [&str; 2] = ["/events", "/policy"];

/// Path of the reason for a hop: `/why?x=3&y=4&at=17`.
const WHY: &str = "/why";

/// Path under which the client of a stream sends back the number of its place: `/reading?stream=17`.
const READING: &str = "/reading";

/// Headers of every response: no foreign content, no embedding in frames, no guessing of types.
pub const HEADERS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
    X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Opener-Policy: same-origin\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\n";

/// The rules for requests to one page.
#[derive(Clone, Debug)]
pub struct Gate {
    hosts: Hosts,
    /// Key that orders must have; `None` if orders are not allowed.
    key: Option<String>,
}

/// How to answer a request that is served.
#[derive(Clone, Debug)]
pub enum Answer {
    /// With a file.
    Asset(&'static Asset),
    /// The history, frame by frame, or the policies alone.
    Events(Kind),
    /// By noting that the client of a stream reads it.
    Reading(u64),
    /// With the reason for a hop from a cell when a decision is due.
    Reason(Cell, Decision),
    /// By passing on an order.
    Order(Order),
}

impl Gate {
    /// The rules of a page that is known as `hosts`; orders need `key`, and are refused without one.
    #[must_use]
    pub fn new(hosts: Hosts, key: Option<String>) -> Self {
        Self { hosts, key }
    }

    /// Checks the head of a request, before its body is read.
    ///
    /// # Errors
    /// Why the request is refused.
    pub fn admit(&self, head: &Head) -> Result<(), Rejection> {
        let host = self.host(head)?;
        self.check_page(head, host)?;
        match head.method.as_str() {
            "GET" if head.path == "/control" => Err(Rejection::new(405, "an order needs POST")),
            "GET" if head.path == WHY && head.length == 0 => reason(&head.query).map(drop),
            "GET" if head.path == READING && head.length == 0 => reading(&head.query).map(drop),
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

    /// Whether a request that is admitted has the key of orders.
    #[must_use]
    pub fn is_keyed(&self, head: &Head) -> bool {
        let given = if STREAMS.contains(&head.path.as_str()) {
            head.query.split('&').find_map(|part| part.strip_prefix("key="))
        } else {
            head.header("x-hopper-key")
        };
        match (&self.key, given) {
            (Some(key), Some(given)) => same(given.as_bytes(), key.as_bytes()),
            _ => false,
        }
    }

    /// The Host header, if it is a name of this server.
    fn host<'a>(&self, head: &'a Head) -> Result<&'a str, Rejection> {
        let host = head.header("host").unwrap_or_default();
        if self.hosts.knows(host) { Ok(host) } else { Err(unknown_host(host)) }
    }

    /// Refuses what a page of another server asks for. A link there may open this page, which has no secret in it.
    fn check_page(&self, head: &Head, host: &str) -> Result<(), Rejection> {
        let opens = head.method == "GET"
            && head.path == "/"
            && head.header("sec-fetch-mode") == Some("navigate")
            && head.header("sec-fetch-dest") == Some("document");
        let site = head.header("sec-fetch-site").unwrap_or("none");
        let is_ours = matches!(site, "same-origin" | "none") || opens;
        let origin = head.header("origin");
        if is_ours && origin.is_none_or(|origin| self.hosts.is_own_origin(origin, host)) {
            return Ok(());
        }
        Err(match origin {
            Some(origin) => foreign_origin(origin),
            None => Rejection::new(403, "requests need to come from this page"),
        })
    }

    fn admit_order(&self, head: &Head, host: &str) -> Result<(), Rejection> {
        if self.key.is_none() {
            return Err(Rejection::new(403, "orders need a monitor started with --control"));
        }
        if head.header("origin").is_none_or(|origin| !self.hosts.is_own_origin(origin, host)) {
            return Err(Rejection::new(
                403,
                "orders need to come from this page, in a browser that sends Origin",
            ));
        }
        if !self.is_keyed(head) {
            return Err(Rejection::new(
                403,
                "orders need the key: open the address that the monitor printed, with all that follows #",
            ));
        }
        if head.header("content-type") != Some("application/json") {
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
            return Ok(Answer::Events(Kind { policy: head.path == STREAMS[1], keyed: self.is_keyed(head) }));
        }
        if head.path == WHY {
            return reason(&head.query);
        }
        if head.path == READING {
            return reading(&head.query);
        }
        asset(&head.path).map(Answer::Asset).ok_or_else(|| Rejection::new(404, "there is no such path"))
    }
}

/// Why a request for another host is refused.
#[must_use]
pub fn unknown_host(host: &str) -> Rejection {
    let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
    let remedy = match super::hosts::host_name(name) {
        Ok(name) => {
            format!("this server is not known as {name:?}; start it with --web-host {name} if it is to be")
        }
        Err(_) => format!("a request needs a Host header that names this server, got {:?}", shortened(host)),
    };
    Rejection::new(421, remedy)
}

/// Why a request of another server's page is refused.
fn foreign_origin(origin: &str) -> Rejection {
    let reason = format!(
        "requests need to come from this page, got one from {:?}; behind a proxy, start the server with --web-host and \
         the name that the browser shows",
        shortened(origin)
    );
    Rejection::new(403, reason)
}

/// The first characters of what a stranger sent.
#[must_use]
pub fn shortened(text: &str) -> &str {
    &text[..text.len().min(80)]
}

/// The cell and the decision that `x=3&y=4&at=17` asks about; each once, in digits.
fn reason(query: &str) -> Result<Answer, Rejection> {
    let need =
        || Rejection::new(400, format!("{WHY} needs x, y and at in digits, as in {WHY}?x=3&y=4&at=17"));
    let field = |name: &str| field(query, name).ok_or_else(need);
    let side = |name: &str| i32::try_from(field(name)?).map_err(|_| need());
    Ok(Answer::Reason(Cell::new(side("x")?, side("y")?), Decision(field("at")?)))
}

/// The place that `stream=17` names.
fn reading(query: &str) -> Result<Answer, Rejection> {
    let need = || Rejection::new(400, format!("{READING} needs stream in digits, as in {READING}?stream=17"));
    field(query, "stream").map(Answer::Reading).ok_or_else(need)
}

/// The number that a field of a query has: at most 15 digits.
fn field(query: &str, name: &str) -> Option<u64> {
    let mut values = query.split('&').filter_map(|part| part.split_once('='));
    let digits = |text: &&str| text.len() <= 15 && text.bytes().all(|byte| byte.is_ascii_digit());
    let value = values.find(|(key, _)| *key == name).map(|(_, value)| value).filter(digits)?;
    value.parse().ok()
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
        let address: core::net::SocketAddr = address.parse().unwrap();
        Gate::new(Hosts::new(address.ip(), &[]), key.map(Into::into))
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

    /// P-WEB-GATE: The page serves known paths to GET requests under its own address, and nothing
    /// else.
    // Long: a table.
    #[test]
    fn only_known_paths_hosts_and_methods_get_anything() {
        let gate = gate("127.0.0.1:8427", None);
        let get = |path: &str, host: &str| status(&gate, &format!("GET {path} HTTP/1.1\nHost: {host}"), "");
        for host in ["127.0.0.1:8427", "localhost:9000", "LOCALHOST:8427", "[::1]:8427", "127.0.0.1"] {
            assert_eq!(get("/", host), 200, "{host}");
        }
        for host in [
            "",
            "evil.example",
            "evil.example:8427",
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
        assert_eq!(
            (get("/reading?stream=7", "localhost"), get("/reading?stream=7", "evil.example")),
            (200, 421)
        );
        for query in ["", "?stream=", "?stream=-1", "?stream=1e3", "?stream=9999999999999999"] {
            assert_eq!(get(&format!("/reading{query}"), "localhost"), 400, "{query}");
        }
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
        let opens = |more: &str| {
            let head = format!(
                "{more} HTTP/1.1\nHost: localhost:8427\nSec-Fetch-Site: cross-site\nSec-Fetch-Mode: navigate"
            );
            status(&gate, &format!("{head}\nSec-Fetch-Dest: document"), "")
        };
        assert_eq!(opens("GET /"), 200, "a link of another page, or the file that --open makes");
        assert_eq!([opens("GET /events"), opens("GET /main.js"), opens("POST /control")], [403; 3]);
        let from = |origin: &str| {
            status(&gate, &format!("GET /events HTTP/1.1\nHost: localhost:8427\nOrigin: {origin}"), "")
        };
        assert_eq!(from("http://localhost:8427"), 200);
        for origin in ["http://evil.example", "null", "http://localhost:3000"] {
            assert_eq!(from(origin), 403, "{origin}");
        }
        let wide = super::tests::gate("0.0.0.0:8427", None);
        assert_eq!(status(&wide, "GET / HTTP/1.1\nHost: 192.168.7.9:8427", ""), 200, "asked for everywhere");
        assert_eq!(status(&wide, "GET / HTTP/1.1\nHost: evil.example:8427", ""), 421);
    }

    const ORDER: &str = "POST /control HTTP/1.1\nHost: localhost:8427\nOrigin: http://localhost:8427\n\
        Content-Type: application/json\nContent-Length: 17\nX-Hopper-Key: 0123456789abcdef";
    const PAUSE: &str = r#"{"order":"pause"}"#;

    /// P-WEB-CONTROL: An order needs `--control`, this page as its origin, the key from the log,
    /// and a valid form.
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
            let Ok(Answer::Events(Kind { policy: false, keyed })) = ask(gate, &head, "") else {
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
}
