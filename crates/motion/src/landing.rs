//! The cell where each branch of a hop lands.

use contract::{Branch, Cell, Direction, Grid};

/// The cell where a hop from `from` towards `direction` lands; may lie outside the grid.
///
/// A slip is a whole hop to the side, so the hopper never leaves the lattice of cells that whole hops connect.
#[must_use]
pub fn landing(grid: &Grid, from: Cell, direction: Direction, branch: Branch) -> Cell {
    match branch {
        Branch::Intended => grid.hop(from, direction),
        Branch::Left => grid.hop(from, direction.left()),
        Branch::Right => grid.hop(from, direction.right()),
        // No law leads elsewhere.
        Branch::Stayed
        | Branch::Held
        | Branch::Stranded
        | Branch::Halted
        | Branch::Elsewhere
        | Branch::RolledAway => from,
    }
}
