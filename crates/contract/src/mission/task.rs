//! What a mission is about: the way of a hopper or a rover, with or without helicopters that look ahead, ground that rovers
//! shall cover, or a task for each robot.

use serde::{Deserialize, Serialize};

use crate::{Designs, RobotSet};

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
    /// Each robot has a task of its own, which [`crate::Brief::tasks_of`] names by its vehicle; these are [`Mixed::required`].
    Mixed(RobotSet),
}

/// A mission of robots of any kind, each with a start and a task of its own: a hopper with a goal hops there, a rover with a
/// goal drives there over uncertain ground, rovers without one cover ground, helicopters look ahead.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mixed {
    /// The robots whose tasks decide the mission: it reaches its goal once they are all done, and fails once one of them
    /// cannot be done any more. At least one.
    pub required: RobotSet,
    /// Hoppers that hop or see otherwise than the brief says.
    pub designs: Designs,
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
    /// Flights before the goal, each with a drive after it, 1 to [`Scout::STAGES_MAX`]. All drives but the last take a Sol
    /// at most.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub stages: u32,
}

impl Scout {
    /// Most stages of a mission.
    pub const STAGES_MAX: u32 = 64;
}

fn one() -> u32 {
    1
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_one(stages: &u32) -> bool {
    *stages == 1
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
