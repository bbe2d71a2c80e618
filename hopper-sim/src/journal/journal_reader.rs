//! A journal read without a lock: its records in the order in which they lie.

use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use contract::{Detail, Record, Route};

use super::reader::Reader;
use super::{FILE_NAME, JournalError, JournalHeader, RECORD_BYTES_MAX, Storage, TORN_BYTES_MAX, frame};
use crate::Attachment;

/// A journal as long as it was when it was opened, so that one still being written may be read.
#[derive(Debug)]
pub struct JournalReader<S: Storage = File> {
    path: PathBuf,
    file: S,
    header: JournalHeader,
    /// Where the first frame begins, bytes.
    start: u64,
    file_bytes: u64,
}

impl JournalReader {
    /// Opens the journal in `dir` as it is: nothing is locked, nothing is cut.
    ///
    /// # Errors
    /// If there is none, it cannot be read, or its header is damaged or of another format.
    pub fn open(dir: &Path) -> Result<Self, JournalError> {
        let path = dir.join(FILE_NAME);
        let file = match File::open(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(JournalError::Missing { path }),
            file => file.map_err(super::io("open", &path))?,
        };
        Self::on(file, path)
    }
}

impl<S: Storage> JournalReader<S> {
    /// The journal that `file` holds; errors call it `path`.
    ///
    /// # Errors
    /// If it cannot be read, or its header is damaged or of another format.
    pub fn on(file: S, path: PathBuf) -> Result<Self, JournalError> {
        let file_bytes = file.bytes().map_err(super::io("read", &path))?;
        let (header, start) = JournalHeader::read(&file, &path)?;
        Ok(Self { path, file, header, start, file_bytes })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn into_file(self) -> S {
        self.file
    }

    /// What is flown, by which build, from which seed.
    #[must_use]
    pub fn header(&self) -> &JournalHeader {
        &self.header
    }

    /// The records from the first one on, read as they are asked for.
    #[must_use]
    pub fn records(&self) -> Records<'_, S> {
        let reader = Reader::new(&self.file, self.start, self.file_bytes);
        Records { history: self, reader, routes: Vec::new(), attachment: None, ended: false }
    }
}

/// The records of a [`JournalReader`]; ends before a torn tail, or with the first error.
#[derive(Debug)]
pub struct Records<'a, S: Storage = File> {
    history: &'a JournalReader<S>,
    reader: Reader<'a, S>,
    /// The routes that the records so far announce.
    routes: Vec<Route>,
    /// What the record names that was read last.
    attachment: Option<Attachment>,
    ended: bool,
}

impl<S: Storage> Records<'_, S> {
    /// Where the next frame begins, bytes; at the end, where the torn tail does.
    #[must_use]
    pub fn offset(&self) -> u64 {
        self.reader.offset
    }

    /// The routes that the records read so far announce, in their order.
    #[must_use]
    pub fn routes(&self) -> &[Route] {
        &self.routes
    }

    /// What the record names that was read last.
    pub(super) fn attachment(&self) -> Option<&Attachment> {
        self.attachment.as_ref()
    }

    /// What the motion model tells of the record that was read last.
    #[must_use]
    pub fn detail(&self) -> Option<&Detail> {
        self.attachment.as_ref().and_then(Attachment::detail)
    }

    /// As [`Records::routes`].
    #[must_use]
    pub fn into_routes(self) -> Vec<Route> {
        self.routes
    }

    /// Bytes after the last whole frame; 0 before the end is reached.
    #[must_use]
    pub fn torn_bytes(&self) -> u64 {
        if self.ended { self.history.file_bytes - self.reader.offset } else { 0 }
    }

    fn record(&mut self) -> Result<Option<Record>, JournalError> {
        let JournalReader { path, file, file_bytes, .. } = self.history;
        let offset = self.reader.offset;
        let bytes_left = file_bytes - offset;
        if bytes_left == 0 {
            return Ok(None);
        }
        let read = |error: io::Error| super::io("read", path)(error);
        let Some(payload) = self.reader.payload().map_err(read)? else {
            // What is searched is bounded, so that no file can keep a reader busy for long.
            let until = (*file_bytes).min(offset.saturating_add(TORN_BYTES_MAX));
            let whole = frame::find(file, offset + 1..until, RECORD_BYTES_MAX).map_err(read)?;
            return match whole {
                Some(whole_at) => Err(JournalError::Corrupt { path: path.clone(), offset, whole_at }),
                None if bytes_left > TORN_BYTES_MAX => {
                    let (max, got) = (TORN_BYTES_MAX, bytes_left);
                    Err(JournalError::TornTooMuch { path: path.clone(), offset, max, got })
                }
                None => Ok(None),
            };
        };
        let (record, attachment) = super::record(payload).map_err(|reason| JournalError::Undecodable {
            path: path.clone(),
            offset,
            reason,
        })?;
        let payload_bytes = payload.len();
        self.routes.extend(attachment.as_ref().and_then(Attachment::route).cloned());
        self.attachment = attachment;
        self.reader.skip(payload_bytes);
        Ok(Some(record))
    }
}

impl<S: Storage> Iterator for Records<'_, S> {
    type Item = Result<Record, JournalError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let record = self.record().transpose();
        self.ended = !matches!(record, Some(Ok(_)));
        record
    }
}
