//! The goal of a helicopter.

use serde::{Deserialize, Serialize};

use crate::mission::kind::Kind;
use crate::wire::Block;

/// Look ahead for robots on the ground: a goal that is never done, and that no mission requires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LookAhead {}

impl Kind for LookAhead {
    const NAME: &'static str = "look_ahead";

    fn parameters(&mut self, _: &mut Block<'_>) {}
}
