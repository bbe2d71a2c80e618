//! The body of a rover that goes from point to point.

use serde::{Deserialize, Serialize};

use crate::mission::kind::Kind;
use crate::wire::Block;

/// A rover that drives from point to point, as fast as the ground lets it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Driver {}

impl Kind for Driver {
    const NAME: &'static str = "driver";

    fn parameters(&mut self, _: &mut Block<'_>) {}
}
