//! Errors of planning on known ground.

use contract::spelling::did_you_mean;

/// Why a plan on known ground cannot be made or executed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KnownError {
    /// The weight of safety is outside 0 to 1.
    #[error("weight of safety: need 0 to 1, got {got}")]
    Weight {
        /// The weight asked for.
        got: f64,
    },
    /// The payoff of the goal is not positive, or too large.
    #[error("payoff of the goal: need a number above 0 and at most 1000000, got {got}")]
    GoalPayoff {
        /// The payoff asked for.
        got: f64,
    },
    /// There is no experiment of this name.
    #[error(
        "experiment: need hard, heterogeneous, sandy or rocks, got {got:?}{}",
        did_you_mean(got, ["hard", "heterogeneous", "sandy", "rocks"])
    )]
    Experiment {
        /// The name asked for.
        got: String,
    },
    /// The number of trials is 0 or too large.
    #[error("trials of an execution: need 1 to {max}, got {got}")]
    Trials {
        /// Largest number of trials.
        max: u64,
        /// The number asked for.
        got: u64,
    },
}
