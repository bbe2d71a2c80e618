//! The goal of a robot that shall be somewhere.

use serde::{Deserialize, Serialize};

use super::GoalKind;
use crate::block::Block;
use crate::codec::DISTANCE;
use crate::mission::kind::Kind;
use crate::{Cell, Grid, Waypoint};

/// Reach a point. A robot that goes from cell to cell has reached it in its cell, one that goes from point to point within the
/// radius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Where it is to go.
    pub at: Waypoint,
    /// How near is near enough, metres.
    pub radius_m: f64,
}

impl Reach {
    /// Reach the middle of a cell.
    #[must_use]
    pub fn of_cell(grid: &Grid, cell: Cell) -> Self {
        Self { at: Waypoint::middle_of(grid, cell), radius_m: 0.0 }
    }
}

impl Kind for Reach {
    const NAME: &'static str = "reach";

    fn parameters(&mut self, block: &mut Block<'_>) {
        block.point("at", "Where it is to go (x, y), metres.", &mut self.at);
        block.float("radius_m", "How near is near enough, metres.", DISTANCE, &mut self.radius_m);
    }
}

impl GoalKind for Reach {
    fn in_words(&self, grid: &Grid) -> Option<String> {
        Some(if self.radius_m > 0.0 {
            format!("to within {} m of {}", self.radius_m, self.at)
        } else {
            format!("to {}", self.at.cell_of(grid))
        })
    }

    fn cell(&self, grid: &Grid, _: u64) -> Option<Cell> {
        Some(self.at.cell_of(grid))
    }

    fn is_place(&self) -> bool {
        true
    }

    fn points(&self, _: &Grid) -> Vec<Waypoint> {
        vec![self.at]
    }

    fn is_reached_at_start(&self, grid: &Grid, start: Waypoint, is_exact: bool) -> bool {
        if is_exact {
            start.distance_m(self.at) <= self.radius_m
        } else {
            start.cell_of(grid) == self.at.cell_of(grid)
        }
    }
}
