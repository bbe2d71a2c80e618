//! Where the records of a flight go.

use contract::limits::PAST_PAGE_RECORDS;
use contract::{Brief, Decision, Detail, PastPage, Record, RobotId, RunId};
use hopper_sim::{Attachment, JournalError, RecordStore};

/// Records go nowhere: what lockstep flies can be flown again. They are kept only where robots go from point to point,
/// since perception then folds records.
pub(super) struct Records {
    run: RunId,
    is_kept: bool,
    kept: Vec<Record>,
    /// What the motion model told, if it tells more than outcomes.
    details: Vec<(Decision, Detail)>,
}

impl Records {
    /// What the motion model told of decisions, in their order.
    pub fn details(&self) -> &[(Decision, Detail)] {
        &self.details
    }

    pub fn of(brief: &Brief) -> Self {
        Self { run: brief.run, is_kept: brief.has_routes(), kept: Vec::new(), details: Vec::new() }
    }
}

impl RecordStore for Records {
    fn run(&self) -> RunId {
        self.run
    }

    fn append(&mut self, record: &Record, attachment: Option<&Attachment>) -> Result<(), JournalError> {
        if let Some(Attachment::Detail(detail)) = attachment {
            self.details.push((record.decision, detail.clone()));
        }
        if self.is_kept {
            self.kept.push(*record);
        }
        Ok(())
    }

    fn detail(&self, decision: Decision) -> Result<Option<Detail>, JournalError> {
        let found = self.details.binary_search_by_key(&decision, |(decision, _)| *decision);
        Ok(found.ok().map(|at| self.details[at].1.clone()))
    }

    fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        let kept = self.kept.iter().skip(from.0 as usize).take(PAST_PAGE_RECORDS);
        Ok(PastPage { run: self.run, robot: RobotId(0), from, records: kept.copied().collect() })
    }
}
