//! What a rover senses of the true ground.

use contract::Cell;
use coverage::TeamMap;
use serde::{Deserialize, Serialize};

use crate::World;

/// How far a rover senses, in every direction (P19 fig. 3a).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sensing {
    /// The 3 × 3 cells around it.
    #[default]
    OneStep,
    /// The 5 × 5 cells around it.
    TwoSteps,
}

impl Sensing {
    /// Cells sensed to each side of the rover.
    #[must_use]
    pub fn range_cells(self) -> i32 {
        match self {
            Sensing::OneStep => 1,
            Sensing::TwoSteps => 2,
        }
    }

    /// Writes into `map` what a rover on `cell` senses of `world`.
    pub(crate) fn sense(self, world: &World, cell: Cell, map: &mut TeamMap) {
        let range = self.range_cells();
        for y in cell.y - range..=cell.y + range {
            for x in cell.x - range..=cell.x + range {
                let seen = Cell::new(x, y);
                map.sense(seen, !world.is_free(seen));
            }
        }
    }
}
