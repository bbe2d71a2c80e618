//! Why there is no planner for a mission.

use contract::{Decision, Name};

/// A request for a planner that cannot be met.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlannerError {
    /// No algorithm has this name.
    #[error("no planner is called {got:?}{hint}")]
    UnknownAlgorithm {
        /// The name asked for.
        got: String,
        /// What may have been meant, for the end of the sentence.
        hint: String,
    },
    /// The clairvoyant planner was asked for where the ground is unseen.
    #[error(
        "the planner clairvoyant suits a hopper that is alone, and needs the whole ground, which only lockstep provides"
    )]
    LockstepOnly,
    /// A mission in lockstep does not go on: nobody decides what is due, or only what is refused.
    #[error("the mission stands still at decision {decision}: {reason}")]
    StandsStill {
        /// The decision that is due.
        decision: Decision,
        /// What was needed and what was got.
        reason: String,
    },
    /// The planner cannot plan this mission.
    #[error("{reason}")]
    Unsuited {
        /// What was needed and what was got.
        reason: String,
    },
}

impl PlannerError {
    /// The sentence for the user of `scenario`.
    #[must_use]
    pub fn in_scenario(&self, scenario: Name) -> String {
        match self {
            PlannerError::Unsuited { reason } => format!("scenario {scenario} {reason}"),
            error => error.to_string(),
        }
    }
}
