//! Warnings about a scenario: it resolves and can be flown, but probably not as intended.

use contract::Cell;
use serde::Serialize;
use terrain::Remark;

/// A warning of `hopper scenario check`. In JSON its tag is `finding`, a promised name.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(tag = "finding", rename_all = "snake_case")]
pub enum Warning {
    /// No chain of hops over passable ground leads to the goal.
    #[error("no chain of hops over passable ground connects the start {start} to the goal {goal}")]
    Unreachable {
        /// Where the mission starts.
        start: Cell,
        /// The goal that cannot be reached.
        goal: Cell,
    },
    /// The step limit ends the mission before the shortest chain of hops does.
    #[error(
        "limits.steps_max = {steps_max} is less than the {steps} steps of the shortest chain of {hops} hops"
    )]
    TooFewSteps {
        /// Fewest hops to the goal if none strays.
        hops: u32,
        /// Steps of the fewest hops in the paper's count: two a hop on hard ground.
        steps: u64,
        /// `limits.steps_max` of the scenario.
        steps_max: u64,
    },
    /// The scenario sets `[guard]` but its profile has no guard.
    #[error("[guard] is not used: profiles of papers fly without a guard")]
    GuardUnused,
    /// Start and goal are the same cell.
    #[error("the start {start} is the goal")]
    StartIsGoal {
        /// The cell that is both.
        start: Cell,
    },
    /// Cells of the elevation model or of a layer hold a value that looks like nodata, and are taken for it.
    #[error("{text}")]
    SuspectedNodata {
        /// The value, as the file stores it.
        value: f64,
        /// Cells that hold it.
        cells: u64,
        /// What is done, and how to settle it.
        text: String,
    },
    /// The elevation model is not read quite as it stands, such as one in feet.
    #[error("{text}")]
    GroundConverted {
        /// What was converted, or taken for what.
        text: String,
    },
}

impl Warning {
    /// Whether it is about the files that the ground comes from.
    #[must_use]
    pub fn is_of_ground(&self) -> bool {
        matches!(self, Self::SuspectedNodata { .. } | Self::GroundConverted { .. })
    }
}

impl From<&Remark> for Warning {
    fn from(remark: &Remark) -> Self {
        let text = remark.to_string();
        match remark {
            Remark::SuspectedNodata { fill, .. } => {
                Self::SuspectedNodata { value: fill.value, cells: fill.cells, text }
            }
            _ => Self::GroundConverted { text },
        }
    }
}
