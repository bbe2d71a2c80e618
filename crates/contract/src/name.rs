//! A short printable name that travels by value.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Up to 31 letters, digits, or `._-+`, zero-padded; what a planner, a scenario or a leader is called.
/// It may become part of a file's name, so it never begins with a dot and holds no slash.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Name([u8; Name::BYTES]);

/// Why a text or a byte array is no [`Name`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a name needs 1 to {max} of the characters A-Z a-z 0-9 . _ - +, not beginning with a dot, got {got:?}", max = Name::BYTES - 1)]
pub struct NameError {
    /// The text that was refused, lossily decoded.
    pub got: String,
}

impl Name {
    /// Bytes on the wire, the closing zero included.
    pub const BYTES: usize = 32;

    /// The empty name: nobody.
    pub const NONE: Name = Name([0; Self::BYTES]);

    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let end = self.0.iter().position(|&b| b == 0).unwrap_or(Self::BYTES);
        std::str::from_utf8(&self.0[..end]).expect("a name is checked to be ASCII when it is made")
    }

    /// The zero-padded bytes as they stand on the wire.
    #[must_use]
    pub fn bytes(&self) -> [u8; Self::BYTES] {
        self.0
    }

    /// Reads a zero-padded array; all zeros is [`Name::NONE`].
    ///
    /// # Errors
    /// If a byte is none a name may have, the last is not zero, or something follows the first zero.
    pub fn from_bytes(bytes: [u8; Self::BYTES]) -> Result<Self, NameError> {
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(Self::BYTES);
        let clean = end < Self::BYTES
            && bytes[0] != b'.'
            && bytes[..end].iter().all(|b| b.is_ascii_alphanumeric() || b"._-+".contains(b))
            && bytes[end..].iter().all(|&b| b == 0);
        if clean { Ok(Name(bytes)) } else { Err(NameError { got: String::from_utf8_lossy(&bytes).into() }) }
    }
}

impl FromStr for Name {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        let mut bytes = [0; Self::BYTES];
        if text.is_empty() || text.len() >= Self::BYTES {
            return Err(NameError { got: text.into() });
        }
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        Name::from_bytes(bytes).map_err(|_| NameError { got: text.into() })
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl Serialize for Name {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        if text.is_empty() { Ok(Name::NONE) } else { text.parse().map_err(serde::de::Error::custom) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_survives_its_bytes() {
        let name: Name = "mdp".parse().unwrap();
        assert_eq!(Name::from_bytes(name.bytes()).unwrap(), name);
        assert_eq!(name.as_str(), "mdp");
    }

    #[test]
    fn an_unprintable_overlong_or_unterminated_name_is_refused() {
        assert!("".parse::<Name>().is_err());
        assert!("two words".parse::<Name>().is_err());
        assert!("../evil".parse::<Name>().is_err());
        assert!("a/b".parse::<Name>().is_err());
        assert!("x".repeat(32).parse::<Name>().is_err());
        assert!(Name::from_bytes([b'x'; 32]).is_err());
        let mut hidden = [0; 32];
        hidden[5] = b'x';
        assert!(Name::from_bytes(hidden).is_err());
    }
}
