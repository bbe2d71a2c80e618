//! What a robot shall do.

mod cover;
mod look_ahead;
mod reach;
mod visit;

use super::kind::kinds;
use crate::{Cell, Grid};

pub use cover::{Cover, CoverMode};
pub use look_ahead::LookAhead;
pub use reach::Reach;
pub use visit::Visit;

kinds! {
    /// What a robot shall do.
    pub enum Goal, each GoalKind, block of 40, refused as "robot.goal" {
        /// Reach a point.
        Reach(Reach) = 1,
        /// Visit goals in turn, from the last to the first again.
        Visit(Visit) = 2,
        /// Visit the ground that can be reached, together with all others that have this goal.
        Cover(Cover) = 3,
        /// Look ahead for others; never done.
        LookAhead(LookAhead) = 4,
    }
}

/// What can be asked of any goal.
pub trait GoalKind {
    /// The cell to go to after so many visits, if the goal is one cell after another.
    fn cell(&self, grid: &Grid, visits: u64) -> Option<Cell> {
        let _ = (grid, visits);
        None
    }
}
