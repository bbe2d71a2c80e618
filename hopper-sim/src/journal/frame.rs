//! Frames: a payload between its length and its checksum, so that a whole one is known from a torn one.

use std::io;
use std::ops::Range;

use super::{JournalError, Storage};

/// Bytes of length and checksum before the payload.
pub(crate) const PREFIX_BYTES: usize = 8;

/// Wraps `payload` into a frame.
///
/// # Errors
/// If it is empty or longer than `payload_max`.
pub(crate) fn seal(payload: &[u8], payload_max: usize) -> Result<Vec<u8>, JournalError> {
    assert!(!payload.is_empty(), "a frame holds something");
    if payload.len() > payload_max {
        return Err(JournalError::TooLong { max: payload_max, got: payload.len() });
    }
    let length = (payload.len() as u32).to_le_bytes();
    let mut frame = Vec::with_capacity(PREFIX_BYTES + payload.len());
    frame.extend(length);
    frame.extend(checksum(length, payload).to_le_bytes());
    frame.extend(payload);
    Ok(frame)
}

/// The payload of the whole frame that `bytes` begins with, if it does.
pub(crate) fn payload(bytes: &[u8], payload_max: usize) -> Option<&[u8]> {
    let (&length, rest) = bytes.split_first_chunk::<4>()?;
    let (&sum, rest) = rest.split_first_chunk::<4>()?;
    let bytes_claimed = u32::from_le_bytes(length) as usize;
    if !(1..=payload_max).contains(&bytes_claimed) {
        return None;
    }
    let payload = rest.get(..bytes_claimed)?;
    (checksum(length, payload) == u32::from_le_bytes(sum)).then_some(payload)
}

/// Covers the length too, so that neither can change alone and zeros are no frame.
fn checksum(length: [u8; 4], payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&length);
    hasher.update(payload);
    hasher.finalize()
}

/// The first whole frame that begins in `range` of `file` and ends in it too.
pub(crate) fn find(file: &impl Storage, range: Range<u64>, payload_max: usize) -> io::Result<Option<u64>> {
    const WINDOW: u64 = 1 << 16;
    let overlap = (PREFIX_BYTES + payload_max) as u64;
    let mut window = vec![0; (WINDOW + overlap) as usize];
    for base in range.clone().step_by(WINDOW as usize) {
        let window = &mut window[..(range.end - base).min(WINDOW + overlap) as usize];
        file.read_exact_at(window, base)?;
        let starts = 0..window.len().min(WINDOW as usize);
        if let Some(start) =
            starts.into_iter().find(|&start| payload(&window[start..], payload_max).is_some())
        {
            return Ok(Some(base + start as u64));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_known_by_its_whole_self_only() {
        let frame = seal(b"hop", 16).unwrap();
        assert_eq!(payload(&frame, 16), Some(&b"hop"[..]));
        for cut in 0..frame.len() {
            assert_eq!(payload(&frame[..cut], 16), None, "cut at {cut}");
        }
        for bit in 0..frame.len() * 8 {
            let mut flipped = frame.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(payload(&flipped, 16), None, "bit {bit}");
        }
        assert_eq!(payload(&[0; 64], 16), None, "zeros are no frame");
        assert!(seal(b"too long", 4).is_err());
    }
}
