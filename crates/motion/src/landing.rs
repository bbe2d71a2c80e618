//! Where on the lattice each branch of a hop comes down.

use contract::{Branch, Cell, Direction, Grid};

/// The cell where a hop from `from` towards `direction` comes down; may lie outside the grid.
///
/// A slip is a whole hop to the side: the hopper keeps to the lattice of its hops.
#[must_use]
pub fn landing(grid: &Grid, from: Cell, direction: Direction, branch: Branch) -> Cell {
    match branch {
        Branch::Intended => grid.hop(from, direction),
        Branch::Left => grid.hop(from, direction.left()),
        Branch::Right => grid.hop(from, direction.right()),
        Branch::Stayed | Branch::Held => from,
    }
}
