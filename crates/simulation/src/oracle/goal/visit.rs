//! Cells in turn, until the actions are made.

use contract::{Cell, Grid, Visit};

use super::Goal;
use crate::oracle::Oracle;

impl Goal for Visit {
    fn cell(&self, _grid: &Grid, visits: u64) -> Option<Cell> {
        Some(self.goals()[visits as usize % self.goals().len()])
    }

    fn last(&self, visits: u64) -> Option<Cell> {
        let last = visits.checked_sub(1)?;
        Some(self.goals()[last as usize % self.goals().len()])
    }

    fn is_reached(&self, oracle: &Oracle, number: usize, _steps: u64) -> bool {
        oracle.turns.actors[number].actions >= self.hops_max
    }
}
