//! What planners of routes are given.

use serde::{Deserialize, Serialize};

/// What planners of routes over uncertain ground are given beside the robots: the seed of their random numbers, how many samples
/// they draw, and in how many stages the mission is driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sampling {
    /// Derived one-way from the scenario, and never the simulator's: it tells nothing of the truth.
    pub seed: u64,
    /// Samples of a rover's planner, 1 to [`crate::limits::SAMPLES_MAX`].
    pub rover_samples: u32,
    /// Samples of a helicopter's planner, 1 to [`crate::limits::SAMPLES_MAX`].
    pub helicopter_samples: u32,
    /// Flights before the goal, each with a drive after it, 1 to [`Sampling::STAGES_MAX`]. All drives but the last take a Sol
    /// at most.
    pub stages: u32,
}

impl Sampling {
    /// Most stages of a mission.
    pub const STAGES_MAX: u32 = 64;
}
