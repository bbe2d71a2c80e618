//! The sensor of a rover that covers ground.

use serde::{Deserialize, Serialize};

use super::{SensorKind, View};
use crate::Grid;
use crate::block::Block;
use crate::codec::whole;
use crate::mission::kind::Kind;

/// The cells at most `range_cells` columns and rows away: 3 × 3 cells for 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Square {
    /// 1 to [`Square::RANGE_MAX_CELLS`].
    pub range_cells: u32,
}

impl Square {
    /// Farthest that a sensor of square view sees, cells.
    pub const RANGE_MAX_CELLS: u32 = 64;
}

impl Kind for Square {
    const NAME: &'static str = "square";

    fn parameters(&mut self, block: &mut Block<'_>) {
        let range = whole(1, Square::RANGE_MAX_CELLS as u64);
        block.whole("range_cells", "How far it reaches to each side, cells.", range, &mut self.range_cells);
    }
}

impl SensorKind for Square {
    fn in_words(&self) -> Option<String> {
        Some(format!("{0} x {0} cells", 2 * self.range_cells + 1))
    }

    fn around(&self, _grid: &Grid, _height_m: f64) -> Option<View> {
        Some(View::square(self.range_cells))
    }
}
