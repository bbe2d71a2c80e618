//! JSON objects whose last member is the CRC-32 of the text before it.

/// Text between the object's last member and the checksum.
const CLOSING: &str = ",\"crc\":\"";

/// Completes `open`, the text of an object without its closing brace, with its checksum and brace.
#[must_use]
pub fn with_checksum(open: &str) -> String {
    format!("{open}{CLOSING}{:08x}\"}}", crc32fast::hash(open.as_bytes()))
}

/// The object of [`with_checksum`] without its checksum.
///
/// # Errors
/// If the checksum is missing or does not match.
pub fn without_checksum(text: &str) -> Result<String, String> {
    let Some((open, got)) = text.rsplit_once(CLOSING) else {
        return Err("need an object that closes with its checksum, got none; it is damaged".into());
    };
    let complete = with_checksum(open);
    let need = &complete[open.len() + CLOSING.len()..];
    if got == need {
        Ok(format!("{open}}}"))
    } else {
        // At most the length of a checksum is quoted, however long the rest is.
        let got: String = got.chars().take(8).collect();
        Err(format!("need checksum {}, got {}; it is damaged", &need[..8], got.escape_debug()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_with_checksum_is_an_object_and_no_bit_of_it_can_change() {
        let line = with_checksum("{\"a\":1");
        assert_eq!(without_checksum(&line).unwrap(), "{\"a\":1}");
        assert!(serde_json::from_str::<serde_json::Value>(&line).unwrap()["crc"].is_string());
        for bit in 0..8 * line.len() {
            let mut bytes = line.clone().into_bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(
                String::from_utf8(bytes)
                    .map_err(|_| ())
                    .and_then(|text| without_checksum(&text).map_err(|_| ()))
                    .is_err()
            );
        }
        assert!(without_checksum(&format!("{line} ")).is_err() && without_checksum("{}").is_err());
    }
}
