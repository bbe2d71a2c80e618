//! Request line and headers of a request.

use std::collections::BTreeMap;

use super::rejection::Rejection;

/// Most bytes of request line and headers.
pub const HEAD_BYTES_MAX: usize = 8 << 10;

/// Most headers of a request.
pub const HEADERS_MAX: usize = 64;

/// The headers that are used, in lower case. Others are skipped.
const NAMES: [&str; 13] = [
    "connection",
    "content-type",
    "host",
    "origin",
    "sec-fetch-dest",
    "sec-fetch-mode",
    "sec-fetch-site",
    "sec-websocket-extensions",
    "sec-websocket-key",
    "sec-websocket-protocol",
    "sec-websocket-version",
    "upgrade",
    "x-hopper-key",
];

/// Headers that are lists, which may come in several pieces.
const LISTS: [&str; 4] = ["connection", "sec-websocket-extensions", "sec-websocket-protocol", "upgrade"];

/// Request line and headers, as far as they are used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Head {
    /// Method, as it came.
    pub method: String,
    /// Path of the target.
    pub path: String,
    /// What follows the question mark of the target.
    pub query: String,
    headers: BTreeMap<&'static str, String>,
    /// Length of the body, bytes.
    pub length: usize,
    /// Whether the length is stated.
    has_length: bool,
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

    /// The value of a header that came.
    ///
    /// # Panics
    /// If the header is none of those that are kept.
    #[must_use]
    pub fn header(&self, name: &str) -> Option<&str> {
        assert!(NAMES.contains(&name), "header {name} is not kept");
        self.headers.get(name).map(String::as_str)
    }

    /// Whether a header that is a list has this item, in any capitals.
    #[must_use]
    pub fn lists(&self, name: &str, item: &str) -> bool {
        self.header(name)
            .is_some_and(|list| list.split(',').any(|found| found.trim().eq_ignore_ascii_case(item)))
    }

    fn take(&mut self, name: &str, value: &[u8]) -> Result<(), Rejection> {
        let text = || match std::str::from_utf8(value) {
            Ok(text) if text.is_ascii() => Ok(text.trim().to_owned()),
            _ => Err(Rejection::new(400, "a header needs ASCII")),
        };
        let name = name.to_ascii_lowercase();
        match name.as_str() {
            "transfer-encoding" => return Err(Rejection::new(411, "an order needs a Content-Length")),
            "content-length" if self.has_length => {
                return Err(Rejection::new(400, "header Content-Length came twice"));
            }
            "content-length" => {
                self.has_length = true;
                let digits = text()?;
                let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
                if !is_number || digits.len() >= 10 {
                    return Err(Rejection::new(413, "a body needs a length in digits"));
                }
                self.length =
                    digits.parse().map_err(|_| Rejection::new(413, "a body needs a length in digits"))?;
                return Ok(());
            }
            _ => {}
        }
        let Some(name) = NAMES.into_iter().find(|kept| *kept == name) else { return Ok(()) };
        let text = text()?;
        match self.headers.get_mut(name) {
            None => _ = self.headers.insert(name, text),
            Some(list) if LISTS.contains(&name) => *list = format!("{list}, {text}"),
            Some(_) => return Err(Rejection::new(400, format!("header {name} came twice"))),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn lists_are_joined_and_other_headers_come_once() {
        let head = |headers: &str| {
            let text = format!("GET / HTTP/1.1\r\n{}\r\n\r\n", headers.replace('\n', "\r\n"));
            Head::parse(text.as_bytes()).map(|parsed| parsed.expect("a whole head").0)
        };
        let joined = head("Connection: keep-alive\nconnection: Upgrade").unwrap();
        assert!(joined.lists("connection", "upgrade") && joined.lists("connection", "keep-alive"));
        assert!(!joined.lists("connection", "up"));
        assert_eq!(head("Origin: a\norigin: a").unwrap_err().0, 400);
        assert_eq!(head("Sec-WebSocket-Key: a\nSec-WebSocket-Key: b").unwrap_err().0, 400);
    }
}
