//! Where hopper-sim appends executed decisions, and reads those of earlier lives.

use std::collections::BTreeMap;

use contract::{Decision, Detail, DetailId, PastPage, Record, RobotId, Route, RunId};

use crate::{Arbiter, Attachment, Journal, JournalError, Storage};

/// Where executed decisions go and come from: the journal, or nowhere in lockstep.
pub trait RecordStore {
    /// The run whose records these are.
    fn run(&self) -> RunId;

    /// Takes a record with what it names; the commit point of a hop.
    ///
    /// # Errors
    /// If it could not be written whole. What was written of it is cut off again.
    fn append(&mut self, record: &Record, attachment: Option<&Attachment>) -> Result<(), JournalError>;

    /// All routes that records announce.
    ///
    /// # Errors
    /// If they cannot be read.
    fn routes(&self) -> Result<Vec<Route>, JournalError> {
        Ok(Vec::new())
    }

    /// What the motion model tells of a decision; `None` if nothing.
    ///
    /// # Errors
    /// If the record cannot be read.
    fn detail(&self, decision: Decision) -> Result<Option<Detail>, JournalError>;

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

    fn append(&mut self, record: &Record, attachment: Option<&Attachment>) -> Result<(), JournalError> {
        Journal::append(self, record, attachment)
    }

    fn routes(&self) -> Result<Vec<Route>, JournalError> {
        Ok(Journal::routes(self).to_vec())
    }

    fn detail(&self, decision: Decision) -> Result<Option<Detail>, JournalError> {
        Journal::detail(self, decision)
    }

    fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        Journal::page(self, from)
    }

    fn check(&self) -> Result<(), JournalError> {
        Journal::check(self)
    }
}

/// Tells the arbiter what was done in earlier lives. A hopper alone needs no more than its last record with what it names.
///
/// # Errors
/// If a record cannot be read back.
pub(crate) fn recall<R: RecordStore>(
    arbiter: &mut Arbiter,
    records: &R,
    last: Option<&Record>,
) -> Result<(), JournalError> {
    let Some(last) = last else { return Ok(()) };
    // The last action of each robot tells where it rests.
    let mut told = BTreeMap::new();
    if arbiter.team().is_none() {
        told.insert(last.robot, (last.decision, last.detail));
        return recall_details(arbiter, records, told);
    }
    arbiter.recall_routes(records.routes()?);
    let mut due = Decision(0);
    while due <= last.decision {
        let page = records.page(due)?;
        arbiter.recall(&page.records);
        told.extend(page.records.iter().map(|record| (record.robot, (record.decision, record.detail))));
        let Some(read) = page.records.last() else {
            return Err(JournalError::OutOfOrder { need: due, got: last.decision });
        };
        due = read.decision.next();
    }
    recall_details(arbiter, records, told)
}

fn recall_details<R: RecordStore>(
    arbiter: &mut Arbiter,
    records: &R,
    told: BTreeMap<RobotId, (Decision, DetailId)>,
) -> Result<(), JournalError> {
    for (robot, (decision, id)) in told {
        if id.is_none() {
            continue;
        }
        match records.detail(decision)? {
            Some(detail) if detail.id() == id => arbiter.recall_detail(robot, detail),
            _ => return Err(JournalError::OtherAttachment { decision }),
        }
    }
    Ok(())
}
