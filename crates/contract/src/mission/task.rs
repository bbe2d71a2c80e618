//! What a mission is about: the way of a hopper or a rover, with or without helicopters that look ahead, or ground that rovers
//! shall cover.

use serde::{Deserialize, Serialize};

/// What a mission is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// A hopper goes from a start to a goal.
    Reach,
    /// A hopper visits goals in turn.
    Patrol,
    /// A hopper goes its way, to a goal or from goal to goal, and helicopters look ahead for it.
    Accompany,
    /// Rovers visit the ground that they can reach.
    Cover(Cover),
    /// A rover drives to a goal over ground of uncertain speed, and helicopters look ahead for it.
    Scout(Scout),
}

/// What planners of routes are given beside the robots: the seed of their random numbers, and how many samples they draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Scout {
    /// Derived one-way from the scenario, and never the simulator's: it tells nothing of the truth.
    pub seed: u64,
    /// Samples of a rover's planner, 1 to [`crate::limits::SAMPLES_MAX`].
    pub rover_samples: u32,
    /// Samples of a helicopter's planner, 1 to [`crate::limits::SAMPLES_MAX`].
    pub helicopter_samples: u32,
}

/// How much ground rovers shall visit, and who visits which.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cover {
    /// Share of the cells that can be reached, 1 to 100 %.
    pub percent: u32,
    /// How the rovers share the ground.
    pub mode: CoverMode,
}

/// Which ground a rover covers (Laîné & Yoshida 2019, section 2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CoverMode {
    /// All rovers cover all ground together ("path overlapping").
    #[default]
    Overlap,
    /// Each rover keeps to the cells that are nearest to its start ("environment sharing").
    Voronoi,
}
