//! The body of a rover that goes from point to point.

use serde::{Deserialize, Serialize};

use super::BodyKind;
use crate::Action;
use crate::block::Block;
use crate::mission::kind::Kind;

/// A rover that drives from point to point, as fast as the ground lets it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Driver {}

impl Kind for Driver {
    const NAME: &'static str = "driver";

    fn parameters(&mut self, _: &mut Block<'_>) {}
}

impl BodyKind for Driver {
    fn word(&self) -> &'static str {
        "rover"
    }

    fn drives(&self) -> bool {
        true
    }

    fn along_route(&self) -> Option<Action> {
        Some(Action::Drive)
    }
}
