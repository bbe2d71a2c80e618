//! What the motion model told of the hops, in the order in which it became known.

use std::collections::{BTreeMap, VecDeque};

use contract::{Decision, Detail, DetailPage, DetailRequest, MonotonicNs, Record, Robots, RunId, State};
use follow::DetailFollower;

/// Number of details that are kept, the last ones: of missions whose hops bounce most it is some 30 MB.
pub const DETAILS_KEPT: usize = 1 << 14;

/// What the motion model told of a decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// The decision.
    pub decision: Decision,
    /// What it told.
    pub detail: Detail,
}

/// The details of a run.
#[derive(Debug, Default)]
pub struct Details {
    missing: DetailFollower,
    known: VecDeque<Told>,
    /// The number of the detail of each decision among all that came.
    numbers: BTreeMap<Decision, u64>,
    /// Number of details that are no longer kept.
    dropped: u64,
}

impl Details {
    pub(super) fn begin(&mut self, run: RunId) {
        self.missing.begin(run);
    }

    /// Number of details known so far.
    pub(super) fn count(&self) -> u64 {
        self.dropped + self.known.len() as u64
    }

    /// The detail of that number of the run and those after it; from the first one kept if it is older.
    pub(super) fn from(&self, number: u64) -> impl ExactSizeIterator<Item = &Told> {
        self.known.iter().skip(number.saturating_sub(self.dropped) as usize)
    }

    /// The detail of a decision; `None` if there is none, or if it is not known or no longer kept.
    #[must_use]
    pub fn of(&self, decision: Decision) -> Option<&Detail> {
        let place = self.numbers.get(&decision)?.checked_sub(self.dropped)?;
        self.known.get(place as usize).map(|told| &told.detail)
    }

    /// All details that are kept, in the order in which they became known.
    pub fn iter(&self) -> impl Iterator<Item = &Told> {
        self.known.iter()
    }

    /// Whether a detail is unknown.
    pub(super) fn is_missing(&self) -> bool {
        !self.missing.is_whole()
    }

    /// Notes an executed decision.
    pub(super) fn record(&mut self, record: &Record) {
        self.missing.record(record);
        self.missing.keep_last(DETAILS_KEPT);
    }

    /// Notes the decision that led to a state.
    pub(super) fn state(&mut self, robots: &Robots, state: &State) {
        self.missing.state(robots, state);
        self.missing.keep_last(DETAILS_KEPT);
    }

    /// Adds a detail that was asked for.
    pub(super) fn page(&mut self, page: &DetailPage) {
        let Some((decision, detail)) = self.missing.page(page.clone()) else { return };
        if self.known.len() == DETAILS_KEPT
            && let Some(oldest) = self.known.pop_front()
        {
            self.numbers.remove(&oldest.decision);
            self.dropped += 1;
        }
        self.numbers.insert(decision, self.count());
        self.known.push_back(Told { decision, detail });
    }

    /// What to ask for at `now`: the first detail that is unknown, and again if it does not come.
    pub(super) fn ask(&mut self, now: MonotonicNs) -> Option<DetailRequest> {
        self.missing.ask(now)
    }
}
