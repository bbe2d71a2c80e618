//! What a robot shall do.

use super::kind::kinds;
use crate::{Cell, Grid};

kinds! {
    /// What a robot shall do.
    pub enum Goal, each GoalKind, block of 40, refused as "robot.goal" {
        reach => Reach(Reach) = 1, "Reach a point.";
        visit => Visit(Visit) = 2, "Visit goals in turn, from the last to the first again.";
        cover => Cover(Cover) = 3, "Visit the ground that can be reached, together with all others that have this goal.";
        look_ahead => LookAhead(LookAhead) = 4, "Look ahead for others; never done.";
    }
}

/// What can be asked of any goal.
pub trait GoalKind {
    /// Where a robot with this goal goes, as `hopper scenario check` says it: `to`, and the place; `None` if to no single place.
    fn in_words(&self, grid: &Grid) -> Option<String> {
        self.cell(grid, 0).map(|cell| format!("to {cell}"))
    }

    /// The cell to go to after so many visits, if the goal is one cell after another.
    fn cell(&self, grid: &Grid, visits: u64) -> Option<Cell> {
        let _ = (grid, visits);
        None
    }
}
