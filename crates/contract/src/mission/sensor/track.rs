//! The sensor of a rover that drives from point to point.

use serde::{Deserialize, Serialize};

use crate::mission::kind::Kind;
use crate::wire::Block;

/// The cells that it drives over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Track {}

impl Kind for Track {
    const NAME: &'static str = "track";

    fn parameters(&mut self, _: &mut Block<'_>) {}
}
