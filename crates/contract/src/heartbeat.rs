//! Proof that a work loop still turns.

use serde::{Deserialize, Serialize};

use crate::{Decision, Incarnation, Name, Role, RunId, Status};

/// One beat. It counts only if [`Heartbeat::counter`] has advanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heartbeat {
    /// Part the process plays.
    pub role: Role,
    /// Life of the process.
    pub incarnation: Incarnation,
    /// Its operating-system process.
    pub pid: u32,
    /// Version of its build.
    pub version: Name,
    /// Algorithm of a planner; [`Name::NONE`] otherwise.
    pub planner: Name,
    /// Beats of this life.
    pub counter: u64,
    /// Run it last saw; 0 for none.
    pub run: RunId,
    /// Decision it last saw.
    pub decision: Decision,
    /// Status it last saw.
    pub status: Status,
}
