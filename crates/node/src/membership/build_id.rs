//! What a build must have in common with those it communicates with.
//!
//! Its version is that of the crates. Its messages are a fingerprint of every service: names, types with their sizes,
//! quality of service. Two builds of one version that disagree on a message would otherwise open services side by side
//! and wait for each other in vain.

use std::fmt;
use std::str::FromStr;

use contract::Name;
use xxhash_rust::xxh3::xxh3_64;

use crate::signature;

/// A build as the label of an instance identifies it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BuildId {
    version: String,
    /// Fingerprint of the services, eight hexadecimal digits.
    messages: String,
}

impl BuildId {
    pub(crate) fn own() -> Self {
        let messages = format!("{:016x}", xxh3_64(signature::all().join("\n").as_bytes()));
        Self { version: version().to_string(), messages: messages[..8].to_owned() }
    }
}

/// Version of this build, which its heartbeats carry.
#[must_use]
pub fn version() -> Name {
    env!("CARGO_PKG_VERSION").parse().unwrap_or(Name::NONE)
}

impl fmt::Display for BuildId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "version {}, messages {}", self.version, self.messages)
    }
}

impl FromStr for BuildId {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let (version, messages) = text.split_once(", messages ").ok_or(())?;
        let version = version.strip_prefix("version ").ok_or(())?;
        Ok(Self { version: version.into(), messages: messages.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_id_is_read_as_it_is_written() {
        assert_eq!(BuildId::own().to_string().parse(), Ok(BuildId::own()));
        for foreign in ["", "0.1.0", "version 0.1.0"] {
            assert_eq!(foreign.parse::<BuildId>(), Err(()), "{foreign:?}");
        }
    }
}
