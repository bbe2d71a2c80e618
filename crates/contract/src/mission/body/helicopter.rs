//! The body of a helicopter.

use serde::{Deserialize, Serialize};

use super::BodyKind;
use crate::block::Block;
use crate::codec::{DISTANCE, SPEED};
use crate::mission::kind::Kind;
use crate::{Action, Direction};

/// Flies from point to point, above all others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Helicopter {
    /// Speed over ground, m/s.
    pub speed_mps: f64,
    /// How far it flies in all, metres.
    pub budget_m: f64,
}

impl Kind for Helicopter {
    const NAME: &'static str = "helicopter";

    fn parameters(&mut self, block: &mut Block<'_>) {
        block.float("speed_mps", "Speed over ground, m/s.", SPEED, &mut self.speed_mps);
        block.float("budget_m", "How far it flies in a stage, metres.", DISTANCE, &mut self.budget_m);
    }
}

impl BodyKind for Helicopter {
    fn word(&self) -> &'static str {
        "helicopter"
    }

    fn in_words(&self, _: Direction) -> String {
        format!(", {} m/s, {} m of flight", self.speed_mps, self.budget_m)
    }

    /// It flies above all others.
    fn is_on_ground(&self) -> bool {
        false
    }

    fn along_route(&self) -> Option<Action> {
        Some(Action::Fly)
    }
}
