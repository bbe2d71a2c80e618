//! The body of a rover that goes from cell to cell.

use serde::{Deserialize, Serialize};

use super::BodyKind;
use crate::Direction;
use crate::block::Block;
use crate::codec::SPEED;
use crate::mission::kind::Kind;

/// Drives to one of the four neighbouring cells at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rover {
    /// Speed on level ground, m/s.
    pub speed_mps: f64,
}

impl Kind for Rover {
    const NAME: &'static str = "rover";

    fn parameters(&mut self, block: &mut Block<'_>) {
        block.float("speed_mps", "Speed on level ground, m/s.", SPEED, &mut self.speed_mps);
    }
}

impl BodyKind for Rover {
    fn word(&self) -> &'static str {
        "rover"
    }

    fn in_words(&self, heading: Direction) -> String {
        format!(" facing {heading}, {} m/s", self.speed_mps)
    }
}
