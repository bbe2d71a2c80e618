//! The hops of a mission in order, a bounded number of them.

use std::collections::VecDeque;

use contract::{Branch, Cell, Collected, Decision, MonotonicNs, Name, Origin, Status, Term, Vetoed};
use report::Executed;

/// Hops that are kept; of a longer mission the last.
pub const HOPS_KEPT: usize = 1 << 16;

/// Changes of command that are kept.
const REIGNS_KEPT: usize = 4096;

/// One executed decision, as far as it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hop {
    /// What became of it.
    pub branch: Branch,
    /// Where it began.
    pub from: Cell,
    /// Where it landed.
    pub to: Cell,
    /// Height of the landing above the datum, metres.
    pub height_m: f64,
    /// Term under which it was commanded.
    pub term: Term,
    /// Steps afterwards, in the papers' count.
    pub steps: u64,
    /// Status afterwards.
    pub status: Status,
    /// Treasures collected so far.
    pub collected: Collected,
    /// Goals visited so far.
    pub visits: u64,
    /// Who chose the action.
    pub origin: Origin,
    /// What the guard vetoed before it.
    pub vetoed: Vetoed,
    /// When the hopper had come to rest before it.
    pub landed: MonotonicNs,
    /// Durations of its stages, nanoseconds, in the order of [`contract::Stage::ALL`].
    pub stages_ns: [u64; 7],
}

impl Hop {
    /// Landed to committed, nanoseconds.
    #[must_use]
    pub fn total_ns(&self) -> u64 {
        self.stages_ns.iter().sum()
    }
}

/// Who commanded from which decision on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reign {
    /// The term.
    pub term: Term,
    /// The algorithm.
    pub planner: Name,
    /// Its process.
    pub pid: u32,
    /// The first decision it commanded.
    pub from: Decision,
}

/// Hops in order without a gap.
#[derive(Clone, Debug, Default)]
pub struct Hops {
    first: u64,
    kept: VecDeque<Hop>,
    reigns: VecDeque<Reign>,
    /// Reigns that are no longer kept.
    reigns_gone: u64,
}

impl Hops {
    /// The decision that is due: the number folded in so far.
    #[must_use]
    pub fn due(&self) -> Decision {
        Decision(self.first + self.kept.len() as u64)
    }

    /// The first decision that is kept.
    #[must_use]
    pub fn first(&self) -> Decision {
        Decision(self.first)
    }

    /// The hop of a decision, if it is kept.
    #[must_use]
    pub fn get(&self, decision: Decision) -> Option<&Hop> {
        self.kept.get(decision.0.checked_sub(self.first)? as usize)
    }

    /// The hops from `decision` on, or from the first that is kept.
    pub fn from(&self, decision: Decision) -> impl DoubleEndedIterator<Item = &Hop> + ExactSizeIterator {
        let skipped = decision.0.saturating_sub(self.first).min(self.kept.len() as u64) as usize;
        self.kept.range(skipped..)
    }

    /// Who commanded, in order; the last is in force.
    pub fn reigns(&self) -> impl DoubleEndedIterator<Item = &Reign> {
        self.reigns.iter()
    }

    /// The reigns from the `number`th of the mission on.
    pub(super) fn reigns_from(&self, number: u64) -> impl Iterator<Item = &Reign> {
        self.reigns.iter().skip(number.saturating_sub(self.reigns_gone) as usize)
    }

    /// Reigns of the mission so far.
    pub(super) fn reigns_count(&self) -> u64 {
        self.reigns_gone + self.reigns.len() as u64
    }

    /// Folds in the decision that is due; any other changes nothing.
    pub fn fold(&mut self, executed: &Executed) {
        if executed.decision != self.due() {
            return;
        }
        let Executed { outcome, leader, .. } = executed;
        if self.reigns.back().is_none_or(|reign| reign.term != leader.term) {
            if self.reigns.len() == REIGNS_KEPT {
                self.reigns.pop_front();
                self.reigns_gone += 1;
            }
            let Executed { decision: from, .. } = *executed;
            self.reigns.push_back(Reign {
                term: leader.term,
                planner: leader.planner,
                pid: leader.pid,
                from,
            });
        }
        if self.kept.len() == HOPS_KEPT {
            self.kept.pop_front();
            self.first += 1;
        }
        self.kept.push_back(Hop {
            branch: outcome.branch,
            from: outcome.from,
            to: outcome.to,
            height_m: executed.pose.height_m,
            term: leader.term,
            steps: executed.steps,
            status: executed.status,
            collected: executed.collected,
            visits: executed.visits,
            origin: executed.origin,
            vetoed: executed.vetoed,
            landed: executed.timing.landed,
            stages_ns: executed.timing.stages_ns(),
        });
    }
}
