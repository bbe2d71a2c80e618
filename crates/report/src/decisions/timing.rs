//! One decision as far as its timing is concerned.

use contract::{Decision, Leader, MonotonicNs, Origin, Record, RobotId, State, Timing};

/// The timing of one executed decision, and what may explain it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecisionTiming {
    /// Number of the decision, from 0.
    pub decision: Decision,
    /// Whose decision it is.
    pub robot: RobotId,
    /// Planner and term that the decision was made in.
    pub leader: Leader,
    /// Who chose the action: a planner or the guard's fallback.
    pub origin: Origin,
    /// Number of actions that the guard vetoed before it.
    pub vetoes: u64,
    /// Work done by the planner, in its own units; 0 if unknown.
    pub work: u64,
    /// Whether the planner's budget cut its work short.
    pub cut: bool,
    /// When each stage ended, on CLOCK_MONOTONIC.
    pub timing: Timing,
}

impl From<&Record> for DecisionTiming {
    fn from(record: &Record) -> Self {
        Self {
            decision: record.decision,
            robot: record.robot,
            leader: record.leader,
            origin: record.origin,
            vetoes: record.vetoed.count(),
            work: record.work,
            cut: record.cut,
            timing: record.timing,
        }
    }
}

impl DecisionTiming {
    /// The decision that led to `state`, with the true time of its commit; `None` at decision 0.
    #[must_use]
    pub fn before(state: &State) -> Option<Self> {
        Some(Self {
            decision: Decision(state.decision.0.checked_sub(1)?),
            robot: state.robot,
            leader: state.leader,
            origin: state.last_origin,
            vetoes: state.last_vetoed.count(),
            work: 0,
            cut: false,
            timing: state.last_timing,
        })
    }
}

/// The first landing of `decisions`, which are in order, since the machine was started last: before it the clock was another.
#[must_use]
pub fn boot_began(decisions: &[DecisionTiming]) -> Option<MonotonicNs> {
    let is_of_other_boot = |pair: &[DecisionTiming]| pair[1].timing.landed < pair[0].timing.committed;
    let other = (1..decisions.len()).rev().find(|&at| is_of_other_boot(&decisions[at - 1..=at]));
    decisions.get(other.unwrap_or(0)).map(|first| first.timing.landed)
}
