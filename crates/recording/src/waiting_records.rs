//! WaitingRecords of decisions, and which are still to be requested before a hop is drawn.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use contract::{Decision, Detail, DetailPage, DetailRequest, MonotonicNs, Record, RunId};
use follow::DetailFollower;

/// Records that wait for their details, at most. Beyond that the first is drawn without, since a detail may never arrive.
const WAITING_MAX: usize = 1024;

/// The details of one run, and the records that wait for theirs.
#[derive(Debug, Default)]
pub(crate) struct WaitingRecords {
    missing: DetailFollower,
    /// Records that are not drawn yet, in their order.
    waiting: VecDeque<Record>,
    /// WaitingRecords of records that wait.
    known: BTreeMap<Decision, Detail>,
    /// The details that are written: one that is asked for again, since the past is read again, is not written again.
    written: BTreeSet<(Decision, [u8; 32])>,
}

impl WaitingRecords {
    /// Those of another run.
    pub fn begin(&mut self, run: RunId) {
        *self = Self::default();
        self.missing.begin(run);
    }

    /// Notes an executed decision, in the order of the decisions.
    pub fn record(&mut self, record: &Record) {
        self.missing.record(record);
        self.waiting.push_back(*record);
    }

    /// Takes an answer; the page if it was missing, and whether it is to be written.
    pub fn page(&mut self, page: DetailPage) -> Option<(DetailPage, bool)> {
        let run = page.run;
        let (decision, detail) = self.missing.page(page)?;
        let is_new = self.written.insert((decision, detail.id().0));
        // What was drawn without its detail is not drawn again.
        if self.waiting.front().is_some_and(|first| first.decision <= decision) {
            self.known.insert(decision, detail.clone());
        }
        Some((DetailPage { run, decision, detail }, is_new))
    }

    /// The next record to be drawn, with its detail if it has one that came; if `all`, whether it came or not.
    pub fn next(&mut self, all: bool) -> Option<(Record, Option<Detail>)> {
        let record = self.waiting.front()?;
        let detail = self.known.remove(&record.decision);
        let is_due = all || record.detail.is_none() || detail.is_some() || self.waiting.len() > WAITING_MAX;
        if !is_due {
            return None;
        }
        Some((self.waiting.pop_front()?, detail))
    }

    /// The records that wait are executed again, since the journal has lost those decisions.
    pub fn forget_past(&mut self) {
        self.missing.forget_missing();
        self.waiting.clear();
        self.known.clear();
    }

    /// Number of details that are written.
    pub fn written(&self) -> usize {
        self.written.len()
    }

    /// Whether a detail is still to come.
    pub fn is_missing(&self) -> bool {
        !self.missing.is_whole()
    }

    /// What to ask for at `now`: the first detail that is missing, and again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<DetailRequest> {
        self.missing.ask(now)
    }
}
