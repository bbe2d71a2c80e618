//! What is odd about a scenario that can be flown all the same.

use contract::Cell;
use serde::Serialize;

/// A warning of `scenario check`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, thiserror::Error)]
#[serde(tag = "finding", rename_all = "snake_case")]
pub enum Finding {
    /// The goal cannot be reached.
    #[error("no chain of hops over passable ground connects the start {start} to the goal {goal}")]
    Unreachable {
        /// Start.
        start: Cell,
        /// Goal.
        goal: Cell,
    },
    /// The goal cannot be reached in time.
    #[error(
        "limits.steps_max = {steps_max} is less than the {steps} steps of the shortest chain of {hops} hops"
    )]
    TooFewSteps {
        /// Fewest hops.
        hops: u32,
        /// Their steps, two a hop.
        steps: u64,
        /// The limit.
        steps_max: u64,
    },
    /// There is a guard, and a profile that flies without.
    #[error("[guard] is not used: profile paper-2023 flies without a guard")]
    GuardUnused,
    /// The mission is over before it begins.
    #[error("the start {start} is the goal")]
    StartIsGoal {
        /// Start.
        start: Cell,
    },
}
