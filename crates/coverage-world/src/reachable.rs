//! Which cells a rover can drive to.

use std::collections::{BTreeSet, VecDeque};

use contract::{Cell, Direction, Grid};

use crate::World;

/// Whether each cell, by index, can be reached from `starts` in steps to one of four neighbours over cells that are
/// `open`. A start is reached whether it is open or not.
pub fn reachable(
    grid: &Grid,
    starts: impl IntoIterator<Item = Cell>,
    open: impl Fn(Cell) -> bool,
) -> Vec<bool> {
    let mut reached = vec![false; grid.cells()];
    let mut to_visit: Vec<Cell> = starts.into_iter().collect();
    for start in &to_visit {
        grid.index(*start).into_iter().for_each(|index| reached[index] = true);
    }
    while let Some(cell) = to_visit.pop() {
        for next in neighbours(cell) {
            if let Some(index) = grid.index(next)
                && !reached[index]
                && open(next)
            {
                reached[index] = true;
                to_visit.push(next);
            }
        }
    }
    reached
}

/// Whether the free cells of `world`, which are connected, stay so without `cell`.
pub(crate) fn is_removable(world: &World, cell: Cell) -> bool {
    let is_free = |at: Cell| at != cell && world.is_free(at);
    let sides: Vec<Cell> = neighbours(cell).into_iter().filter(|side| is_free(*side)).collect();
    // Two sides in turn are connected by the corner between them. Mostly that connects all of them.
    let corner = |one: Cell, other: Cell| Cell::new(one.x + other.x - cell.x, one.y + other.y - cell.y);
    let gaps = |(n, side): (usize, &Cell)| {
        let next = sides[(n + 1) % sides.len()];
        let opposite = next.x == side.x || next.y == side.y;
        opposite || !is_free(corner(*side, next))
    };
    sides.iter().enumerate().filter(|side| gaps(*side)).count() <= 1 || connects(&sides, is_free)
}

/// Whether ways over open cells connect all of `cells`.
fn connects(cells: &[Cell], open: impl Fn(Cell) -> bool) -> bool {
    let mut missing: BTreeSet<Cell> = cells.iter().skip(1).copied().collect();
    let mut reached: BTreeSet<Cell> = cells.iter().take(1).copied().collect();
    let mut to_visit: VecDeque<Cell> = reached.iter().copied().collect();
    while let Some(cell) = to_visit.pop_front() {
        missing.remove(&cell);
        if missing.is_empty() {
            return true;
        }
        to_visit.extend(neighbours(cell).into_iter().filter(|next| open(*next) && reached.insert(*next)));
    }
    missing.is_empty()
}

/// The four cells beside `cell`, some of them possibly off the grid.
pub(crate) fn neighbours(cell: Cell) -> [Cell; 4] {
    Direction::ALL.map(|direction| neighbour(cell, direction))
}

/// The cell beside `cell`, possibly off the grid.
pub(crate) fn neighbour(cell: Cell, direction: Direction) -> Cell {
    let (dx, dy) = direction.step();
    Cell::new(cell.x + dx, cell.y + dy)
}
