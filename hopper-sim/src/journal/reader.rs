//! Frames one after the other, read from the disk in chunks.

use std::io;

use super::{RECORD_BYTES_MAX, Storage, frame};

/// Bytes read at once: some hundred records, and less than a page of the past is long in coming.
const CHUNK_BYTES: u64 = 1 << 15;

/// Reads frames of records from an offset up to an end.
#[derive(Debug)]
pub(super) struct Reader<'a, S> {
    file: &'a S,
    /// Where the next frame begins, bytes.
    pub offset: u64,
    /// Where the last one ends, or a torn one is cut off.
    end: u64,
    window: Vec<u8>,
    /// Where the window begins.
    base: u64,
}

impl<'a, S: Storage> Reader<'a, S> {
    pub fn new(file: &'a S, offset: u64, end: u64) -> Self {
        Self { file, offset, end, window: Vec::new(), base: offset }
    }

    /// The payload of the next frame, if it is whole; the reader stays before it until it is
    /// [skipped](Self::skip).
    pub fn payload(&mut self) -> io::Result<Option<&[u8]>> {
        let most = (frame::PREFIX_BYTES + RECORD_BYTES_MAX) as u64;
        let left = self.end.saturating_sub(self.offset);
        let held = (self.base + self.window.len() as u64).saturating_sub(self.offset);
        if held < left.min(most) {
            self.window.resize(left.min(CHUNK_BYTES) as usize, 0);
            self.base = self.offset;
            if let Err(error) = self.file.read_exact_at(&mut self.window, self.offset) {
                self.window.clear();
                return Err(error);
            }
        }
        let from = (self.offset - self.base) as usize;
        Ok(frame::payload(&self.window[from..], RECORD_BYTES_MAX))
    }

    /// Goes on behind a frame of so many bytes of payload.
    pub fn skip(&mut self, payload_bytes: usize) {
        self.offset += (frame::PREFIX_BYTES + payload_bytes) as u64;
    }
}
