//! The journal: a directory that holds every executed decision of one run, the only durable thing here.
//!
//! ```text
//! DIR/hops.journal   magic, format, frames of the build's version and of the header's text, then one frame per
//!                    decision from 0 on; flock'ed by the process that writes
//! DIR/lock           flock'ed by it too; holds its pid as text
//! frame              length u32 | CRC-32 of length and payload u32 | payload, little-endian
//! ```
//!
//! A header is text (`header.rs`), records are bincode.
//!
//! What a record names by its fingerprint stands behind it in its payload ([`Attachment`]): the points of the route that it announces, or
//! what the motion model tells of it.
//!
//! A frame is written whole or not at all: a write that fails is cut back, a write that death cut
//! short is cut when the journal is opened next. Only a tail is ever cut; a broken frame with whole
//! ones behind it is damage, and refused. Memory is constant, however long the journal.
//!
//! Before each append the file is looked for at its path: if it was deleted, replaced or cut there, nothing is appended,
//! since what is written then would be missing after a restart, and its hop be flown twice.

mod audit;
mod codec;
#[cfg(unix)]
mod directory;
mod disagreement;
mod error;
mod folder;
mod frame;
mod header;
mod index;
mod journal_reader;
mod lock;
#[cfg(unix)]
mod locking;
mod reader;
mod show;
mod storage;
mod verification;
mod world;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use contract::limits::PAST_PAGE_RECORDS;
use contract::wire::RecordV5;
use contract::{Action, Decision, Detail, PastPage, Record, Route, Waypoint};

use terrain::Terrain;

use crate::Attachment;
use crate::mission::{ROBOT, genesis};
use audit::Audit;
use index::Index;
use reader::Reader;

pub use audit::Fault;
pub use error::{Displacement, JournalError};
pub use folder::Folder;
pub use header::{FORMAT, JournalHeader};
pub use journal_reader::{JournalReader, Records};
pub use lock::{LOCK_NAME, Lock};
pub use show::Show;
pub use storage::{Located, Storage};
pub use verification::{Verification, verify};

/// Name of the journal's file in its directory.
pub const FILE_NAME: &str = "hops.journal";

/// Most bytes of an encoded record, with the longest attachment.
const RECORD_BYTES_MAX: usize = 8192;

/// Most bytes of a torn tail: a frame cut short, and what a file system may put behind it. More than that is
/// no tail, and is not cut.
pub const TORN_BYTES_MAX: u64 = 1 << 20;

/// A journal open for writing, locked against every other writer.
#[derive(Debug)]
pub struct Journal<S: Storage = File> {
    path: PathBuf,
    file: S,
    header: JournalHeader,
    index: Index,
    /// Where the last whole frame ends, bytes.
    end: u64,
    last: Option<Record>,
    /// The routes that records announce, in their order.
    routes: Vec<Route>,
    torn_bytes: u64,
    /// Whether bytes may lie beyond `end`.
    ragged: bool,
    sync: bool,
    /// Storage that is nobody else's needs none.
    locks: Vec<Lock>,
}

impl<S: Storage> Journal<S> {
    /// A new journal in `file`, which is empty and nobody else's. A death in its midst leaves half a
    /// header, which is no journal.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create_on(file: S, header: &JournalHeader, sync: bool) -> Result<Self, JournalError> {
        let (path, bytes) = (PathBuf::from(FILE_NAME), header.seal()?);
        file.write_all_at(&bytes, 0).map_err(io("create", &path))?;
        if sync {
            file.sync().map_err(io("sync", &path))?;
        }
        Ok(Self::empty(file, path, header, bytes.len(), sync))
    }

    /// As [`Journal::resume`], from a `file` that is nobody else's.
    ///
    /// # Errors
    /// As [`Journal::resume`].
    pub fn resume_on(
        file: S,
        expected: &JournalHeader,
        terrain: &Arc<Terrain>,
        sync: bool,
    ) -> Result<Self, JournalError> {
        Self::read(file, FILE_NAME.into(), sync, Some(terrain), |header| expected.check(header))
    }

    fn empty(file: S, path: PathBuf, header: &JournalHeader, header_bytes: usize, sync: bool) -> Self {
        Self {
            file,
            path,
            header: header.clone(),
            index: Index::default(),
            end: header_bytes as u64,
            last: None,
            routes: Vec::new(),
            torn_bytes: 0,
            ragged: false,
            sync,
            locks: Vec::new(),
        }
    }

    /// Reads a journal through. With `terrain`, the ground of its mission, every record is executed again; without, nothing may be
    /// flown from it.
    fn read(
        file: S,
        path: PathBuf,
        sync: bool,
        terrain: Option<&Arc<Terrain>>,
        allowed: impl Fn(&JournalHeader) -> Result<(), JournalError>,
    ) -> Result<Self, JournalError> {
        let history = JournalReader::on(file, path.clone())?;
        let mut records = history.records();
        allowed(history.header())?;
        let mut digest = genesis(&history.header().brief, history.header().seed);
        let (mut index, mut last) = (Index::default(), None::<Record>);
        let mut audit = terrain.map(|terrain| Audit::new(history.header(), Some(Arc::clone(terrain))));
        loop {
            let offset = records.offset();
            let Some(record) = records.next().transpose()? else { break };
            let due = Decision(index.len());
            digest = continues(&record, due, digest)?;
            if let Some(audit) = &mut audit {
                audit.observe(&record, records.attachment()).map_err(|fault| JournalError::NotSound {
                    path: path.clone(),
                    faults: vec![fault.to_string()],
                })?;
            }
            index.push(offset);
            last = Some(record);
        }
        let (end, torn_bytes) = (records.offset(), records.torn_bytes());
        let routes = records.into_routes();
        let mut journal = Self {
            header: history.header().clone(),
            file: history.into_file(),
            index,
            end,
            last,
            routes,
            torn_bytes,
            ragged: torn_bytes > 0,
            sync,
            locks: Vec::new(),
            path,
        };
        journal.trim().map_err(io("cut the torn tail of", &journal.path))?;
        if sync {
            // What an earlier life wrote is about to be published again, so it must be durable too.
            journal.file.sync().map_err(io("sync", &journal.path))?;
        }
        Ok(journal)
    }

    /// Appends `record` with what it names: once this returns `Ok` the hop has happened.
    ///
    /// # Errors
    /// If the record is not the next one, names another attachment, cannot be written, or the file is no longer what its path leads to; then
    /// the journal is as before, and the very same record may be appended again.
    pub fn append(&mut self, record: &Record, attachment: Option<&Attachment>) -> Result<(), JournalError> {
        if !Attachment::fits(attachment, record) {
            return Err(JournalError::OtherAttachment { decision: record.decision });
        }
        let payload = match attachment {
            None => codec::encode(record)?,
            Some(Attachment::Route(route)) => codec::encode(&(record, route.waypoints()))?,
            Some(Attachment::Detail(detail)) => codec::encode(&(record, detail))?,
        };
        self.append_payload(record, &payload)?;
        self.routes.extend(attachment.and_then(Attachment::route).cloned());
        Ok(())
    }

    /// The routes that records announce, in their order.
    #[must_use]
    pub fn routes(&self) -> &[Route] {
        &self.routes
    }

    fn append_payload(&mut self, record: &Record, payload: &[u8]) -> Result<(), JournalError> {
        let need = self.last.as_ref().map_or_else(|| self.genesis(), |last| last.digest);
        continues(record, Decision(self.len()), need)?;
        self.check()?;
        let frame = frame::seal(payload, RECORD_BYTES_MAX)?;
        if let Err(error) = self.write(&frame) {
            // What cannot be cut now is cut before the next append, or when the journal is opened.
            let _ = self.trim();
            return Err(io("append to", &self.path)(error));
        }
        self.ragged = false;
        self.index.push(self.end);
        self.end += frame.len() as u64;
        self.last = Some(*record);
        Ok(())
    }

    fn write(&mut self, frame: &[u8]) -> std::io::Result<()> {
        self.trim()?;
        self.ragged = true;
        self.file.write_all_at(frame, self.end)?;
        if self.sync { self.file.sync() } else { Ok(()) }
    }

    /// Checks that the path of the journal still leads to this very file, as long as it was left.
    ///
    /// # Errors
    /// [`JournalError::Displaced`] says what became of it.
    pub fn check(&self) -> Result<(), JournalError> {
        let need = self.end;
        let displacement = match self.file.locate(&self.path).map_err(io("look at", &self.path))? {
            Located::Here { bytes } if bytes == need || bytes > need && self.ragged => return Ok(()),
            Located::Here { bytes: got } => Displacement::Resized { need, got },
            Located::Elsewhere => Displacement::Replaced,
            Located::Nowhere => Displacement::Gone,
        };
        Err(JournalError::Displaced { path: self.path.clone(), displacement })
    }

    /// Cuts whatever lies beyond the last whole frame.
    fn trim(&mut self) -> std::io::Result<()> {
        if self.ragged {
            self.file.cut(self.end)?;
            if self.sync {
                self.file.sync()?;
            }
            self.ragged = false;
        }
        Ok(())
    }

    /// The page of records that begins at decision `from`; empty beyond the last.
    ///
    /// # Errors
    /// If a record cannot be read back, or is not the one that was appended.
    pub fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        let records: Vec<Record> =
            self.records_from(from.0).take(PAST_PAGE_RECORDS).collect::<Result<_, _>>()?;
        let mut digest = records.first().map_or_else(|| self.genesis(), |first| first.previous);
        // The records first: a range from the last number of all cannot be asked for its next.
        for (record, due) in records.iter().zip(from.0..) {
            digest = continues(record, Decision(due), digest)?;
        }
        Ok(PastPage { run: self.header.run(), robot: ROBOT, from, records })
    }

    /// Every record in order, read as it is asked for.
    pub fn records(&self) -> impl Iterator<Item = Result<Record, JournalError>> + '_ {
        self.records_from(0)
    }

    /// What the motion model tells of a decision; `None` if it tells nothing, or there is no such record.
    ///
    /// # Errors
    /// If the record cannot be read back.
    pub fn detail(&self, decision: Decision) -> Result<Option<Detail>, JournalError> {
        let read = self.payloads_from(decision.0).next().transpose()?;
        Ok(match read {
            Some((_, Some(Attachment::Detail(detail)))) => Some(detail),
            _ => None,
        })
    }

    /// Every record with what it names, in order, read as it is asked for.
    pub fn attached(&self) -> impl Iterator<Item = Result<(Record, Option<Attachment>), JournalError>> + '_ {
        self.payloads_from(0)
    }

    /// The records from `first` on, read as they are asked for; ends with the first error.
    fn records_from(&self, first: u64) -> impl Iterator<Item = Result<Record, JournalError>> + '_ {
        self.payloads_from(first).map(|read| read.map(|(record, _)| record))
    }

    /// As [`Journal::records_from`], with what they name.
    fn payloads_from(&self, first: u64) -> impl Iterator<Item = Result<Attached, JournalError>> + '_ {
        let mut start = self.index.before(first).map(|known| self.walk(known, first));
        let mut reader = None;
        std::iter::from_fn(move || {
            match start.take() {
                Some(Ok(offset)) => reader = Some(Reader::new(&self.file, offset, self.end)),
                Some(Err(error)) => return Some(Err(error)),
                None => {}
            }
            let read = self.next_of(reader.as_mut().filter(|reader| reader.offset < self.end)?);
            if read.is_err() {
                reader = None;
            }
            Some(read)
        })
    }

    /// Where the frame of `record` begins, from that of an earlier one.
    fn walk(&self, (mut at, mut offset): (u64, u64), record: u64) -> Result<u64, JournalError> {
        while at < record {
            let mut length = [0; 4];
            self.file.read_exact_at(&mut length, offset).map_err(io("read", &self.path))?;
            offset += (frame::PREFIX_BYTES + u32::from_le_bytes(length) as usize) as u64;
            at += 1;
        }
        Ok(offset)
    }

    /// The record that `reader` stands before, which then stands behind it.
    fn next_of(&self, reader: &mut Reader<'_, S>) -> Result<Attached, JournalError> {
        let offset = reader.offset;
        let undecodable = |reason| JournalError::Undecodable { path: self.path.clone(), offset, reason };
        let payload = reader.payload().map_err(io("read", &self.path))?;
        let payload = payload.ok_or_else(|| undecodable("its checksum no longer holds".into()))?;
        let read = self::record(payload).map_err(undecodable)?;
        let payload_bytes = payload.len();
        reader.skip(payload_bytes);
        Ok(read)
    }

    /// What is flown, by which build, from which seed.
    #[must_use]
    pub fn header(&self) -> &JournalHeader {
        &self.header
    }

    /// The newest record; `None` before the first decision.
    #[must_use]
    pub fn last(&self) -> Option<&Record> {
        self.last.as_ref()
    }

    /// The number of records, which is the decision that is due.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.index.len()
    }

    /// Whether nothing has been executed yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.index.len() == 0
    }

    /// Bytes that were cut off as a torn tail when the journal was opened.
    #[must_use]
    pub fn torn_bytes(&self) -> u64 {
        self.torn_bytes
    }

    fn genesis(&self) -> contract::Digest {
        genesis(&self.header.brief, self.header.seed)
    }
}

/// The record of the whole frame that `bytes` begins with; `None` if they are none. For whoever looks at what was
/// written without opening the journal.
#[must_use]
pub fn record_of(bytes: &[u8]) -> Option<Record> {
    let (record, _) = record(frame::payload(bytes, RECORD_BYTES_MAX)?).ok()?;
    Some(record)
}

/// A record with what it names.
type Attached = (Record, Option<Attachment>);

/// The record of a frame's payload, with what it names. The bounds of the wire are those of the journal too; they are stated there.
fn record(payload: &[u8]) -> Result<Attached, String> {
    let (record, rest): (Record, _) = codec::decode_first(payload)?;
    let record = Record::try_from(&RecordV5::from(&record)).map_err(|refusal| refusal.to_string())?;
    if let Action::Announce(id) = record.action {
        let waypoints: Vec<Waypoint> = codec::decode(rest)?;
        let route = Route::new(waypoints).map_err(|refusal| refusal.to_string())?;
        return if route.id() == id {
            Ok((record, Some(Attachment::Route(route))))
        } else {
            Err(format!("needs the points of route {id}, got those of {}", route.id()))
        };
    }
    if rest.is_empty() {
        return Ok((record, None));
    }
    let detail: Detail = codec::decode(rest)?;
    let detail = detail.checked().map_err(|refusal| refusal.to_string())?;
    Ok((Record { detail: detail.id(), ..record }, Some(Attachment::Detail(detail))))
}

/// Checks that `record` is the `due` one and continues `digest`; gives the digest after it.
fn continues(
    record: &Record,
    due: Decision,
    digest: contract::Digest,
) -> Result<contract::Digest, JournalError> {
    if record.decision != due {
        return Err(JournalError::OutOfOrder { need: due, got: record.decision });
    }
    if record.previous != digest {
        return Err(JournalError::BrokenChain { decision: due, need: digest, got: record.previous });
    }
    Ok(record.digest)
}

fn io<'a>(action: &'static str, path: &'a Path) -> impl Fn(std::io::Error) -> JournalError + 'a {
    move |source| JournalError::Io { action, path: path.into(), source }
}
