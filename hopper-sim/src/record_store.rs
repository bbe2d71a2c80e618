//! Where hopper-sim appends executed decisions, and reads those of earlier lives.

use contract::{Decision, PastPage, Record, Route, RunId};

use crate::{Arbiter, Journal, JournalError, Storage};

/// Where executed decisions go and come from: the journal, or nowhere in lockstep.
pub trait RecordStore {
    /// The run whose records these are.
    fn run(&self) -> RunId;

    /// Takes a record; the commit point of a hop.
    ///
    /// # Errors
    /// If it could not be written whole. What was written of it is cut off again.
    fn append(&mut self, record: &Record) -> Result<(), JournalError>;

    /// As [`RecordStore::append`], with the route that the record announces.
    ///
    /// # Errors
    /// As [`RecordStore::append`].
    fn append_announced(&mut self, record: &Record, _route: &Route) -> Result<(), JournalError> {
        self.append(record)
    }

    /// All routes that records announce.
    ///
    /// # Errors
    /// If they cannot be read.
    fn routes(&self) -> Result<Vec<Route>, JournalError> {
        Ok(Vec::new())
    }

    /// The records from a decision on, at most [`contract::limits::PAST_PAGE_RECORDS`].
    ///
    /// # Errors
    /// If they cannot be read.
    fn page(&self, from: Decision) -> Result<PastPage, JournalError>;

    /// Checks that what was taken would be found again.
    ///
    /// # Errors
    /// If the file was deleted, replaced or changed.
    fn check(&self) -> Result<(), JournalError> {
        Ok(())
    }
}

impl<S: Storage> RecordStore for Journal<S> {
    fn run(&self) -> RunId {
        self.header().run()
    }

    fn append(&mut self, record: &Record) -> Result<(), JournalError> {
        Journal::append(self, record)
    }

    fn append_announced(&mut self, record: &Record, route: &Route) -> Result<(), JournalError> {
        Journal::append_announced(self, record, route)
    }

    fn routes(&self) -> Result<Vec<Route>, JournalError> {
        Ok(Journal::routes(self).to_vec())
    }

    fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        Journal::page(self, from)
    }

    fn check(&self) -> Result<(), JournalError> {
        Journal::check(self)
    }
}

/// Tells the arbiter what was done in earlier lives. A hopper alone needs no more than its last record.
///
/// # Errors
/// If a record cannot be read back.
pub(crate) fn recall<R: RecordStore>(
    arbiter: &mut Arbiter,
    records: &R,
    last: Option<&Record>,
) -> Result<(), JournalError> {
    if arbiter.team().is_none() {
        return Ok(());
    }
    let Some(last) = last else { return Ok(()) };
    arbiter.recall_routes(records.routes()?);
    let mut due = Decision(0);
    while due <= last.decision {
        let page = records.page(due)?;
        arbiter.recall(&page.records);
        let Some(read) = page.records.last() else {
            return Err(JournalError::OutOfOrder { need: due, got: last.decision });
        };
        due = read.decision.next();
    }
    Ok(())
}
