//! The sensor of a rover that drives from point to point.

use serde::{Deserialize, Serialize};

use super::SensorKind;
use crate::block::Block;
use crate::mission::kind::Kind;

/// The cells that it drives over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Track {}

impl Kind for Track {
    const NAME: &'static str = "track";

    fn parameters(&mut self, _: &mut Block<'_>) {}
}

impl SensorKind for Track {
    fn in_words(&self) -> String {
        "the cells that it drives over".into()
    }
}
