//! Objects in JSON that close with the CRC-32 of all that stands before it, as text.

/// What stands before the checksum.
const CLOSING: &str = ",\"crc\":\"";

/// The text of an object that lacks its closing brace, closed.
#[must_use]
pub fn seal(open: &str) -> String {
    format!("{open}{CLOSING}{:08x}\"}}", crc32fast::hash(open.as_bytes()))
}

/// The object that was sealed, closed without its checksum.
///
/// # Errors
/// If it is not as it was sealed.
pub fn unseal(text: &str) -> Result<String, String> {
    let Some((open, got)) = text.rsplit_once(CLOSING) else {
        return Err("need an object that closes with its checksum, got none; it is damaged".into());
    };
    let sealed = seal(open);
    let need = &sealed[open.len() + CLOSING.len()..];
    if got == need {
        Ok(format!("{open}}}"))
    } else {
        // What follows the checksum is not of interest, however long it is.
        let got: String = got.chars().take(8).collect();
        Err(format!("need checksum {}, got {}; it is damaged", &need[..8], got.escape_debug()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sealed_object_is_an_object_and_no_bit_of_it_can_change() {
        let sealed = seal("{\"a\":1");
        assert_eq!(unseal(&sealed).unwrap(), "{\"a\":1}");
        assert!(serde_json::from_str::<serde_json::Value>(&sealed).unwrap()["crc"].is_string());
        for bit in 0..8 * sealed.len() {
            let mut bytes = sealed.clone().into_bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(
                String::from_utf8(bytes)
                    .map_err(|_| ())
                    .and_then(|text| unseal(&text).map_err(|_| ()))
                    .is_err()
            );
        }
        assert!(unseal(&format!("{sealed} ")).is_err() && unseal("{}").is_err());
    }
}
