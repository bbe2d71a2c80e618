//! What a simulation came to.

use serde::Serialize;

use crate::coverage::Coverage;
use crate::violation::Violation;
use crate::world::Line;

/// What a simulation came to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// The first promise that did not hold, if one did not.
    pub violation: Option<Violation>,
    /// Events simulated.
    pub events: u64,
    /// Decisions executed, those of earlier runs included.
    pub decisions: u64,
    /// Time that passed for the processes, nanoseconds.
    pub virtual_ns: u64,
    /// Longest time in which nothing was executed and no fault was felt, nanoseconds.
    pub idle_ns: u64,
    /// Longest time of these in which no plan, pause, action or reservation explained it either, nanoseconds.
    pub calm_ns: u64,
    /// How often each event happened that the simulation shall meet.
    pub coverage: Coverage,
    /// What happened, if it was to be traced.
    pub trace: Vec<Line>,
}
