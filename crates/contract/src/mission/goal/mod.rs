//! What a robot shall do.

use super::kind::kinds;
use crate::{Cell, Grid, Ground, Waypoint};

kinds! {
    /// What a robot shall do.
    pub enum Goal, each GoalKind, block of 40, refused as "robot.goal" {
        reach => Reach(Reach) = 1, "Reach a point.";
        visit => Visit(Visit) = 2, "Visit goals in turn, from the last to the first again.";
        cover => Cover(Cover) = 3, "Visit the ground that can be reached, together with all others that have this goal.";
        look_ahead => LookAhead(LookAhead) = 4, "Look ahead for others; never done.";
    }
}

/// What can be asked of any goal. A goal of which everything holds as it is by default is a task that has no place, and that each
/// robot does on its own.
pub trait GoalKind {
    /// Where a robot with this goal goes, as `hopper scenario check` says it: `to`, and the place; `None` if to no single place.
    fn in_words(&self, grid: &Grid) -> Option<String> {
        self.cell(grid, 0).map(|cell| format!("to {cell}"))
    }

    /// The cell to go to after so many visits, if it is known before the mission.
    fn cell(&self, grid: &Grid, visits: u64) -> Option<Cell> {
        let _ = (grid, visits);
        None
    }

    /// The cell to go to after so many visits, by what has been seen of each cell, in index order: what planners plan for whose hopper
    /// began on the cell `start`.
    fn cell_by(&self, grid: &Grid, seen: &[Option<Ground>], start: Cell, visits: u64) -> Option<Cell> {
        let _ = (seen, start);
        self.cell(grid, visits)
    }

    /// Whether it is reached by standing somewhere.
    fn is_place(&self) -> bool {
        false
    }

    /// The cells by which displays mark it, in the order of the visits.
    fn cells(&self, grid: &Grid) -> Vec<Cell> {
        self.cell(grid, 0).into_iter().collect()
    }

    /// As [`GoalKind::cells`], but exactly.
    fn points(&self, grid: &Grid) -> Vec<Waypoint> {
        self.cells(grid).into_iter().map(|cell| Waypoint::middle_of(grid, cell)).collect()
    }

    /// Whether a robot that starts at the point `start` has reached it before its first action. `is_exact` is for robots that go from
    /// point to point: they have to be within its radius, others in its cell.
    fn is_reached_at_start(&self, grid: &Grid, start: Waypoint, is_exact: bool) -> bool {
        let _ = (grid, start, is_exact);
        false
    }

    /// How much ground shall be visited, if that is the goal. The robot may then stay wherever it is once the ground is covered.
    fn cover(&self) -> Option<Cover> {
        None
    }

    /// Whether it only serves the goals of others, and is itself never reached.
    fn looks_ahead(&self) -> bool {
        false
    }
}
