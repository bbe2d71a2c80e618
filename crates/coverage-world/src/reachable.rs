//! Which cells a rover can drive to.

use contract::{Cell, Direction, Grid};

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

/// Finds out whether cells are needed to connect others; keeps its memory.
#[derive(Default)]
pub(crate) struct Connections {
    /// By cell index; false between searches.
    reached: Vec<bool>,
    queue: Vec<Cell>,
}

impl Connections {
    /// Whether the free cells of a grid, which are connected, stay so without `cell`.
    pub(crate) fn hold_without(&mut self, grid: &Grid, cell: Cell, free: impl Fn(Cell) -> bool) -> bool {
        let is_free = |at: Cell| at != cell && free(at);
        let sides: Vec<Cell> = neighbours(cell).into_iter().filter(|side| is_free(*side)).collect();
        // Two sides in turn are connected by the corner between them. Mostly that connects all of them.
        let corner = |one: Cell, other: Cell| Cell::new(one.x + other.x - cell.x, one.y + other.y - cell.y);
        let gap = |(n, side): (usize, &Cell)| {
            let next = sides[(n + 1) % sides.len()];
            let opposite = next.x == side.x || next.y == side.y;
            opposite || !is_free(corner(*side, next))
        };
        sides.iter().enumerate().filter(|side| gap(*side)).count() <= 1 || self.connect(grid, &sides, is_free)
    }

    /// Whether ways over open cells connect all of `cells`.
    fn connect(&mut self, grid: &Grid, cells: &[Cell], open: impl Fn(Cell) -> bool) -> bool {
        self.reached.resize(grid.cells(), false);
        for first in cells.iter().take(1) {
            self.queue.push(*first);
            grid.index(*first).into_iter().for_each(|index| self.reached[index] = true);
        }
        let mut reached = 0;
        let mut next = 0;
        while let Some(&cell) = self.queue.get(next)
            && reached < cells.len()
        {
            next += 1;
            reached += usize::from(cells.contains(&cell));
            for beside in neighbours(cell) {
                if open(beside)
                    && let Some(index) = grid.index(beside)
                    && !self.reached[index]
                {
                    self.reached[index] = true;
                    self.queue.push(beside);
                }
            }
        }
        for index in self.queue.drain(..).filter_map(|cell| grid.index(cell)) {
            self.reached[index] = false;
        }
        reached == cells.len()
    }
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
