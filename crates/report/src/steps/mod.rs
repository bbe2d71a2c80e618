//! Where the time of each decision went, which missed its budget, and what explains it.
//!
//! Home of `hopper latency report`. [`crate::Latency`] folds a mission of any length in constant memory; this
//! account keeps every decision, so that the longest can be named.

mod account;
mod cause;
mod compare;
mod plot;

pub use account::{Conditions, Group, StageTimes, StepAccount, StepReport, Worst};
pub use cause::{Cause, Happening};
pub use compare::{Comparison, compare};
pub use plot::plot;

use contract::{Decision, Leader, Origin, Record, State, Timing};

/// One decision, as far as time is concerned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The decision.
    pub decision: Decision,
    /// Who was in command.
    pub leader: Leader,
    /// Who chose the action.
    pub origin: Origin,
    /// Actions that the guard vetoed before it.
    pub vetoes: u64,
    /// Work the planner did, in its own units; 0 if unknown.
    pub work: u64,
    /// Whether a budget cut that work short.
    pub cut: bool,
    /// Its moments.
    pub timing: Timing,
}

impl From<&Record> for Step {
    fn from(record: &Record) -> Self {
        Self {
            decision: record.decision,
            leader: record.leader,
            origin: record.origin,
            vetoes: record.vetoed.count(),
            work: record.work,
            cut: record.cut,
            timing: record.timing,
        }
    }
}

impl Step {
    /// The decision that led to `state`, with the true moment of its commit; `None` at decision 0.
    #[must_use]
    pub fn before(state: &State) -> Option<Self> {
        Some(Self {
            decision: Decision(state.decision.0.checked_sub(1)?),
            leader: state.leader,
            origin: state.last_origin,
            vetoes: state.last_vetoed.count(),
            work: 0,
            cut: false,
            timing: state.last_timing,
        })
    }
}
