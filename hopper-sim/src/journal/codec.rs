//! The only place that knows bincode: values to bytes and back.
//!
//! bincode is unmaintained (RUSTSEC-2025-0141). Magic, version, length and checksum stand around its
//! bytes, a limit guards its decoder, and golden bytes pin them down, so that another codec can
//! write the same.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::JournalError;

/// Most bytes a decoder may claim.
const BYTES_MAX: usize = 1 << 24;

/// Little-endian integers of fixed width, lengths as u64, variants as u32.
fn config() -> impl bincode::config::Config {
    bincode::config::standard().with_little_endian().with_fixed_int_encoding().with_limit::<BYTES_MAX>()
}

/// The bytes of `value`.
///
/// # Errors
/// If they would be more than [`BYTES_MAX`].
pub(crate) fn encode(value: &impl Serialize) -> Result<Vec<u8>, JournalError> {
    let bytes = bincode::serde::encode_to_vec(value, config()).expect("journal types are plain data");
    if bytes.len() > BYTES_MAX {
        return Err(JournalError::TooLong { max: BYTES_MAX, got: bytes.len() });
    }
    Ok(bytes)
}

/// The value of `bytes`, all of them.
///
/// # Errors
/// What about them is no such value.
pub(crate) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    let (value, read) =
        bincode::serde::decode_from_slice(bytes, config()).map_err(|error| error.to_string())?;
    if read != bytes.len() {
        return Err(format!("needs {read} bytes, got {}", bytes.len()));
    }
    Ok(value)
}

/// The value that `bytes` begin with, and those after it.
///
/// # Errors
/// What about them is no such value.
pub(crate) fn decode_first<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), String> {
    let (value, read) =
        bincode::serde::decode_from_slice(bytes, config()).map_err(|error| error.to_string())?;
    Ok((value, &bytes[read..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_the_limit_is_refused_before_memory_is_claimed() {
        let mut bytes = u64::MAX.to_le_bytes().to_vec();
        bytes.extend([b'x'; 64]);
        assert!(decode::<String>(&bytes).is_err());
        assert!(decode::<Vec<u64>>(&(BYTES_MAX as u64).to_le_bytes()).is_err());
    }

    #[test]
    fn bytes_left_over_are_refused() {
        let mut bytes = encode(&7_u64).unwrap();
        assert_eq!(decode::<u64>(&bytes), Ok(7));
        bytes.push(0);
        assert!(decode::<u64>(&bytes).is_err());
    }
}
