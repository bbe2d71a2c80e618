//! What a planner tells the hopper to do.

use serde::{Deserialize, Serialize};

use crate::{Action, Decision, Digest, Incarnation, MonotonicNs, Name, RobotId, RunId, Term};

/// One command, repeated until the state moves on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Command {
    /// The run it is meant for.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// The decision it answers.
    pub decision: Decision,
    /// [`crate::State::digest`] of the state it answers: the same decision may be due again on another past, if the
    /// journal has lost its tail meanwhile.
    pub digest: Digest,
    /// The term it speaks for: the current one, or current + 1 to take over.
    pub term: Term,
    /// Action to execute, unless the guard vetoes it.
    pub action: Action,
    /// [`crate::ObservedMap::observation`] of the map it was decided on.
    pub observation: u64,
    /// Algorithm of the planner.
    pub planner: Name,
    /// Life of the planner.
    pub incarnation: Incarnation,
    /// Process of the planner; 0 in lockstep.
    pub pid: u32,
    /// Work done, in the planner's own units (sweeps, expansions).
    pub work: u64,
    /// Whether a budget cut the work short.
    pub cut: bool,
    /// When perception had sensed.
    pub sensed: MonotonicNs,
    /// When perception published the map.
    pub map_published: MonotonicNs,
    /// When planning began.
    pub planning_started: MonotonicNs,
    /// When planning ended.
    pub planning_ended: MonotonicNs,
}
