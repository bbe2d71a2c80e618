//! The outcome of one case on one world.

use serde::{Deserialize, Serialize};

use crate::cases::PERCENTS;

/// How long the longest path was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// To each of [`PERCENTS`]; none for a share that the case is not asked for.
    pub steps: [Option<u64>; PERCENTS.len()],
}

impl Steps {
    /// To one of [`PERCENTS`].
    ///
    /// # Panics
    /// If the case was not asked for it.
    pub fn to(&self, percent: u32) -> u64 {
        let place = PERCENTS.iter().position(|known| *known == percent);
        place.and_then(|place| self.steps[place]).expect("a share that the case is asked for")
    }
}
