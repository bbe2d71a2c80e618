//! What can go wrong with a planner.

use crate::ALGORITHMS;

/// Why there is no planner.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlannerError {
    /// Nobody knows the algorithm.
    #[error("a planner needs one of the algorithms {known}, got {got:?}", known = ALGORITHMS.join(", "))]
    UnknownAlgorithm {
        /// The name asked for.
        got: String,
    },
    /// The clairvoyant planner was asked to plan from what has been seen.
    #[error(
        "the planner clairvoyant needs the whole ground, which only lockstep shows it; got a mission to discover"
    )]
    LockstepOnly,
    /// The planner cannot take on this mission.
    #[error("{reason}")]
    Unsuited {
        /// What was needed and what was got.
        reason: String,
    },
}
