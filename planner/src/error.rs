//! Why there is no planner for a mission.

use contract::{Decision, Name};

use crate::names::{AHEAD_ALGORITHMS, ALGORITHMS, COVER_ALGORITHMS, DRIVE_ALGORITHMS, FLY_ALGORITHMS};

/// A request for a planner that cannot be met.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlannerError {
    /// No algorithm has this name.
    #[error(
        "a planner needs one of the algorithms {known}, for a hopper's helicopter {ahead}, or for rovers {cover}, or for a \
         rover that is scouted for {drive}, or for its helicopter {fly}, got {got:?}",
        known = ALGORITHMS.join(", "), ahead = AHEAD_ALGORITHMS.join(", "), cover = COVER_ALGORITHMS.join(", "),
        drive = DRIVE_ALGORITHMS.join(", "), fly = FLY_ALGORITHMS.join(", ")
    )]
    UnknownAlgorithm {
        /// The name asked for.
        got: String,
    },
    /// The clairvoyant planner was asked for where the ground is unseen.
    #[error(
        "the planner clairvoyant needs the whole ground, which only lockstep provides; got a mission over unseen ground"
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
