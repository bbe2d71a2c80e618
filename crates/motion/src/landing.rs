//! The cell where each branch of a hop lands.

use contract::{Branch, Cell, Direction, Grid, TableLanding};

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

/// The cell of a landing of a motion table by a hop from `from` towards `direction`; may lie outside the grid.
#[must_use]
pub fn table_landing(grid: &Grid, from: Cell, direction: Direction, landing: &TableLanding) -> Cell {
    let [ahead, aside] = [direction, direction.left()].map(|towards| grid.hop(Cell::default(), towards));
    let (forward, left) = (i32::from(landing.forward), i32::from(landing.left));
    Cell::new(from.x + forward * ahead.x + left * aside.x, from.y + forward * ahead.y + left * aside.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_landing_of_a_table_turns_with_the_hop() {
        let grid = Grid::new(40, 40, 1.0, 2).unwrap();
        let from = Cell::new(20, 20);
        for direction in Direction::ALL {
            let at = |forward, left| {
                table_landing(&grid, from, direction, &TableLanding { forward, left, probability: 1.0 })
            };
            let hops = |towards: &[Direction]| towards.iter().fold(from, |cell, to| grid.hop(cell, *to));
            assert_eq!(at(0, 0), from);
            assert_eq!(at(2, 0), hops(&[direction; 2]));
            assert_eq!(at(1, 1), hops(&[direction, direction.left()]));
            assert_eq!(at(0, -1), hops(&[direction.right()]));
            assert_eq!(at(-1, 0), hops(&[direction.left().left()]));
        }
    }
}
