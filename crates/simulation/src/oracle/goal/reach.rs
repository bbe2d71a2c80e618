//! A point, which robots that go from cell to cell reach in its cell.

use contract::{Account, Cell, Grid, Reach};

use super::Goal;
use crate::oracle::{Oracle, along};

impl Goal for Reach {
    fn cell(&self, grid: &Grid, _visits: u64) -> Option<Cell> {
        let along = |metres: f64| (metres / grid.cell_size_m).floor() as i32;
        Some(Cell::new(along(self.at.x_m), along(self.at.y_m)))
    }

    fn is_reached(&self, oracle: &Oracle, number: usize, steps: u64) -> bool {
        let (brief, actor) = (&oracle.mission.brief, &oracle.turns.actors[number]);
        if actor.body().along_route().is_some() {
            return along::has_reached(oracle, number, self);
        }
        let in_time = brief.account != Account::Hopper || steps <= brief.limits.steps_max;
        self.cell(&brief.grid, 0) == Some(actor.cell) && in_time
    }
}
