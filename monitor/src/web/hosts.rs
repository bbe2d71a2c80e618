//! The names under which a server on this machine is known.
//!
//! Every page in the user's browser can reach a server on loopback, and the owner of a name can let it point to loopback
//! (DNS rebinding). So a name is trusted if its meaning is fixed, as that of `localhost` and of numeric addresses is, or if
//! whoever started the server has named it. The port is not compared: with `ssh -L` it is another one.

use core::net::IpAddr;

/// The names under which one server is known.
#[derive(Clone, Debug)]
pub struct Hosts {
    /// Address that the server is bound to.
    address: IpAddr,
    /// Names given on the command line, in lower case.
    named: Vec<String>,
}

impl Hosts {
    /// The hosts of a server that is bound to `address`: its own names and the `named` ones.
    #[must_use]
    pub fn new(address: IpAddr, named: &[String]) -> Self {
        Self { address, named: named.iter().map(|name| name.to_ascii_lowercase()).collect() }
    }

    /// Whether a Host header, a name with or without port, is of this server.
    #[must_use]
    pub fn knows(&self, authority: &str) -> bool {
        let Some(name) = name_of(authority) else { return false };
        is_loopback(name) || self.has_named(name) || self.is_own_address(name)
    }

    /// Whether an Origin header is of a page that this server sent, given the Host header of the same request. Behind a proxy
    /// that ends TLS, or that rewrites Host, it is of a host that was named.
    #[must_use]
    pub fn is_own_origin(&self, origin: &str, host: &str) -> bool {
        let Some((scheme, authority)) = origin.split_once("://") else { return false };
        let is_named = name_of(authority).is_some_and(|name| self.has_named(name));
        match scheme {
            "http" => is_named || authority == host && self.knows(host),
            "https" => is_named,
            _ => false,
        }
    }

    fn has_named(&self, name: &str) -> bool {
        self.named.iter().any(|named| named.eq_ignore_ascii_case(name))
    }

    /// Whether a name is a numeric address of this server: that of a server bound to all addresses may be any.
    fn is_own_address(&self, name: &str) -> bool {
        address_of(name).is_some_and(|ip| ip == self.address || self.address.is_unspecified())
    }
}

/// Whether an Origin header is of a page on this machine. A process here can connect without being a page.
#[must_use]
pub fn is_loopback_origin(origin: &str) -> bool {
    let authority = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    authority.and_then(name_of).is_some_and(is_loopback)
}

/// A name for `--web-host`: what a browser shows between `http://` and the port.
///
/// # Errors
/// What was needed and what was got, in a sentence.
pub fn host_name(text: &str) -> Result<String, String> {
    let is_name = !text.is_empty()
        && text.len() <= 253
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-._".contains(&byte))
        && !text.starts_with(['-', '.']);
    let is_address = address_of(text).is_some();
    if is_name || is_address {
        return Ok(text.to_ascii_lowercase());
    }
    Err(format!("a host is a name without scheme, port or wildcard, e.g. rover.example; got {text:?}"))
}

/// The name of an authority; `None` if its port is none.
fn name_of(authority: &str) -> Option<&str> {
    let (name, port) = match authority.rsplit_once(':') {
        Some((name, port)) if !port.ends_with(']') => (name, Some(port)),
        _ => (authority, None),
    };
    let is_port = |port: &str| port.bytes().all(|byte| byte.is_ascii_digit()) && port.parse() != Ok(0_u16);
    match port {
        Some(port) if !is_port(port) || port.parse::<u16>().is_err() => None,
        _ => Some(name),
    }
}

fn is_loopback(name: &str) -> bool {
    name.eq_ignore_ascii_case("localhost") || address_of(name).is_some_and(|ip| ip.is_loopback())
}

/// The numeric address that a name is: IPv6 needs brackets.
fn address_of(name: &str) -> Option<IpAddr> {
    match name.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        Some(literal) => literal.parse().ok().map(IpAddr::V6),
        None => name.parse().ok().map(IpAddr::V4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hosts(address: &str, named: &[&str]) -> Hosts {
        let named: Vec<String> = named.iter().map(|name| host_name(name).unwrap()).collect();
        Hosts::new(address.parse().unwrap(), &named)
    }

    /// P-WEB-HOSTS: Page and Foxglove server accept localhost and numeric addresses at any port,
    /// and names that `--web-host` gives, so that `ssh -L` works and DNS rebinding does not.
    #[test]
    fn loopback_names_have_any_port_and_other_names_are_given() {
        let own = hosts("127.0.0.1", &[]);
        for host in [
            "localhost:9000",
            "LocalHost",
            "127.0.0.1",
            "127.0.0.1:1",
            "127.9.9.9:65535",
            "[::1]:9000",
            "[::1]",
        ] {
            assert!(own.knows(host), "{host}");
        }
        for host in [
            "",
            ":8427",
            "evil.example",
            "evil.example:8427",
            "localhost.evil.example",
            "localhost.:8427",
            "x.localhost:8427",
            "localhost:",
            "localhost:0",
            "localhost:00",
            "localhost:65536",
            "localhost:+80",
            "localhost:80:80",
            "localhost@evil.example",
            "evil.example@localhost",
            "evil.example#localhost",
            "127.0.0.1.nip.io:8427",
            "127.1:8427",
            "0x7f.1:8427",
            "2130706433",
            "0.0.0.0:8427",
            "10.0.0.1:8427",
            "::1",
            "[::1",
            "[::2]:1",
            "[127.0.0.1]:1",
            "[::ffff:127.0.0.1]",
            "[::1%lo]:1",
            "localhost\t",
            "*",
        ] {
            assert!(!own.knows(host), "{host:?}");
        }
        assert!(hosts("10.0.0.1", &[]).knows("10.0.0.1:9000"), "the address that it is bound to");
        assert!(hosts("0.0.0.0", &[]).knows("192.168.7.9:9000"), "asked for everywhere");
        assert!(!hosts("0.0.0.0", &[]).knows("evil.example:8427"));
        let named = hosts("127.0.0.1", &["Rover.example"]);
        assert!(
            named.knows("rover.example:8427") && named.knows("ROVER.EXAMPLE") && named.knows("localhost:1")
        );
        assert!(!named.knows("x.rover.example") && !named.knows("rover.example.evil.example"));
    }

    /// P-WEB-HOSTS.
    #[test]
    fn an_origin_is_the_host_itself_or_one_that_was_given() {
        let named = hosts("127.0.0.1", &["rover.example"]);
        for (origin, host) in [
            ("http://localhost:9000", "localhost:9000"),
            ("http://rover.example", "rover.example"),
            ("https://rover.example", "rover.example"),
            ("https://rover.example", "127.0.0.1:8427"),
        ] {
            assert!(named.is_own_origin(origin, host), "{origin} {host}");
        }
        for (origin, host) in [
            ("http://localhost:9000", "localhost:8427"),
            ("https://localhost:9000", "localhost:9000"),
            ("http://evil.example", "evil.example"),
            ("http://evil.example", "localhost:8427"),
            ("null", "localhost:8427"),
            ("file://", "localhost:8427"),
            ("localhost:8427", "localhost:8427"),
            ("ftp://rover.example", "rover.example"),
        ] {
            assert!(!named.is_own_origin(origin, host), "{origin} {host}");
        }
        for origin in ["http://localhost:3000", "https://127.0.0.1", "http://[::1]:8080"] {
            assert!(is_loopback_origin(origin), "{origin}");
        }
        for origin in
            ["null", "file://", "http://localhost.evil.example", "https://evil.example", "ws://localhost"]
        {
            assert!(!is_loopback_origin(origin), "{origin}");
        }
    }

    #[test]
    fn a_host_is_a_name_alone() {
        for text in ["rover.example", "rover", "192.168.7.9", "[fe80::1]", "a_b-c.d"] {
            assert!(host_name(text).is_ok(), "{text}");
        }
        for text in [
            "",
            "*",
            "*.example",
            "http://rover.example",
            "rover.example:80",
            "a b",
            "a/b",
            "-x",
            ".x",
            "fe80::1",
        ] {
            assert!(host_name(text).is_err(), "{text:?}");
        }
    }
}
