//! How landings are paced, and what was published.

use contract::{Decision, MonotonicNs, Pace};

use crate::tempo::Tempo;

/// How landings are paced, and what was published.
#[derive(Clone, Debug)]
pub(super) struct Pacing {
    pub tempo: Tempo,
    /// The last decision whose state was published by this life of hopper-sim.
    pub published: Option<Decision>,
    /// When that state was first published.
    pub told: MonotonicNs,
    /// The decision that was due when this life began.
    pub began: Decision,
}

impl Pacing {
    /// That of a life of hopper-sim that has landed nothing yet.
    pub fn begin(control: bool, pace: Pace) -> Self {
        Self { tempo: Tempo::begin(control, pace), published: None, told: MonotonicNs(0), began: Decision(0) }
    }
}
