//! Errors of flying a case.

use contract::grid::GridError;
use coverage::Algorithm;
use coverage_world::{SetupError, WorldError};

/// Why a case cannot be flown to its end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum P19Error {
    /// The grid of its world has no such size.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Its world cannot be drawn.
    #[error(transparent)]
    World(#[from] WorldError),
    /// Its rovers cannot start.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The mission does not end.
    #[error("{algorithm} does not cover {percent} % of the world of seed {seed} within {steps_max} steps")]
    NotCovered {
        /// Planner of all rovers.
        algorithm: Algorithm,
        /// Share of the reachable cells that was to be covered.
        percent: u32,
        /// Seed of the world.
        seed: u64,
        /// Limit of the mission.
        steps_max: u64,
    },
}
