//! Why a known-map plan cannot be made.

/// What was needed, and what was got.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KnownError {
    /// A weight outside its range.
    #[error("a weight of safety needs to be 0 to 1, got {got}")]
    Weight {
        /// The weight asked for.
        got: f64,
    },
    /// A goal payoff that is none.
    #[error("the payoff of the goal needs to be above 0 and at most 1000000, got {got}")]
    GoalPayoff {
        /// The payoff asked for.
        got: f64,
    },
    /// No such experiment.
    #[error("an experiment is hard, heterogeneous, sandy or rocks, got {got:?}")]
    Experiment {
        /// The name asked for.
        got: String,
    },
    /// Nothing to execute.
    #[error("an execution needs 1 to {max} trials, got {got}")]
    Trials {
        /// Most trials at once.
        max: u64,
        /// Trials asked for.
        got: u64,
    },
}
