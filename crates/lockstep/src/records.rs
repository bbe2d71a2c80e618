//! Where the records of a flight go.

use contract::limits::PAST_PAGE_RECORDS;
use contract::{Brief, Decision, PastPage, Record, RobotId, RunId};
use hopper_sim::{JournalError, RecordStore};

/// Records go nowhere: what lockstep flies can be flown again. They are kept only where robots go from point to point,
/// since perception then folds records.
pub(super) struct Records {
    run: RunId,
    is_kept: bool,
    kept: Vec<Record>,
}

impl Records {
    pub fn of(brief: &Brief) -> Self {
        Self { run: brief.run, is_kept: brief.has_routes(), kept: Vec::new() }
    }
}

impl RecordStore for Records {
    fn run(&self) -> RunId {
        self.run
    }

    fn append(&mut self, record: &Record) -> Result<(), JournalError> {
        if self.is_kept {
            self.kept.push(*record);
        }
        Ok(())
    }

    fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        let kept = self.kept.iter().skip(from.0 as usize).take(PAST_PAGE_RECORDS);
        Ok(PastPage { run: self.run, robot: RobotId(0), from, records: kept.copied().collect() })
    }
}
