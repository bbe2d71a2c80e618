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
}
