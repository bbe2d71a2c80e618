//! The goal of a helicopter.

use serde::{Deserialize, Serialize};

use super::GoalKind;
use crate::block::Block;
use crate::mission::kind::Kind;

/// Look ahead for robots on the ground: a goal that is never done, and that no mission requires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LookAhead {}

impl Kind for LookAhead {
    const NAME: &'static str = "look_ahead";

    fn parameters(&mut self, _: &mut Block<'_>) {}
}

impl GoalKind for LookAhead {
    fn looks_ahead(&self) -> bool {
        true
    }
}
