//! What has to be covered, and how much of it is.

use contract::{Cell, CoverMode, Grid};
use coverage::region;

use crate::reachable::reachable;

/// The progress of a team of rovers.
#[derive(Clone, Debug)]
pub struct Progress {
    grid: Grid,
    percent: u32,
    mode: CoverMode,
    /// What each rover has to cover; one entry for all of them in [`CoverMode::Overlap`].
    parts: Vec<Part>,
    /// By cell index.
    visited: Vec<bool>,
    visited_cells: usize,
}

/// Ground to cover, and how much of it is.
#[derive(Clone, Copy, Debug)]
struct Part {
    /// Cells that count.
    cells: usize,
    /// Cells to visit until the part is done.
    need: usize,
    visited: usize,
}

impl Progress {
    /// What rovers that start at `starts` have to cover where `is_free` lets them drive: `percent` of all cells that can be
    /// reached from any start, or, in [`CoverMode::Voronoi`], of those of its region that each rover can reach without
    /// leaving it. Nothing is visited yet.
    #[must_use]
    pub fn new(
        grid: Grid,
        is_free: impl Fn(Cell) -> bool,
        starts: &[Cell],
        mode: CoverMode,
        percent: u32,
    ) -> Self {
        let part = |cells: Vec<bool>| Part::new(&cells, percent, 0);
        let starts = || starts.iter().copied();
        let region = |(robot, start): (usize, Cell)| {
            let is_own = |cell| is_free(cell) && region::nearest_start(starts(), cell) == robot;
            part(reachable(&grid, [start], is_own))
        };
        let parts = match mode {
            CoverMode::Overlap => vec![part(reachable(&grid, starts(), &is_free))],
            CoverMode::Voronoi => starts().enumerate().map(region).collect(),
        };
        Self { grid, percent, mode, parts, visited: vec![false; grid.cells()], visited_cells: 0 }
    }

    /// Takes note that rover `robot` has entered `cell`; whether it is the first.
    ///
    /// # Panics
    /// If the cell is outside the grid.
    pub fn visit(&mut self, robot: usize, cell: Cell) -> bool {
        let index = self.grid.index(cell).expect("a rover visits cells of the grid");
        let is_first = !std::mem::replace(&mut self.visited[index], true);
        if is_first {
            self.visited_cells += 1;
            let number = self.part_number(robot);
            self.parts[number].visited += 1;
        }
        is_first
    }

    /// A rover has failed. `active` are the cells of those that can still drive; `is_free` says where, the cells of failed
    /// ones left out. What only the failed one could reach no longer counts where others may take over; if none is left, all
    /// counts as before.
    pub fn strand(&mut self, active: impl IntoIterator<Item = Cell>, is_free: impl Fn(Cell) -> bool) {
        let mut active = active.into_iter().peekable();
        if self.mode == CoverMode::Overlap && active.peek().is_some() {
            let mut cells = reachable(&self.grid, active, is_free);
            for (counts, visited) in cells.iter_mut().zip(&self.visited) {
                *counts |= visited;
            }
            self.parts = vec![Part::new(&cells, self.percent, self.visited_cells)];
        }
    }

    /// Whether rover `robot` has nothing left to cover.
    #[must_use]
    pub fn is_done(&self, robot: usize) -> bool {
        self.parts[self.part_number(robot)].is_done()
    }

    /// Whether all is covered that was asked for.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        self.parts.iter().all(Part::is_done)
    }

    /// Cells that count; of regions, their sum.
    #[must_use]
    pub fn reachable_cells(&self) -> usize {
        self.parts.iter().map(|part| part.cells).sum()
    }

    /// Distinct cells that at least one rover stood on.
    #[must_use]
    pub fn visited_cells(&self) -> usize {
        self.visited_cells
    }

    fn part_number(&self, robot: usize) -> usize {
        if self.mode == CoverMode::Overlap { 0 } else { robot }
    }
}

impl Part {
    fn new(cells: &[bool], percent: u32, visited: usize) -> Self {
        let cells = cells.iter().filter(|counts| **counts).count();
        Self { cells, need: cells_of(percent, cells), visited }
    }

    fn is_done(&self) -> bool {
        self.visited >= self.need
    }
}

/// `percent` of `count` cells, rounded up.
pub(crate) fn cells_of(percent: u32, count: usize) -> usize {
    (percent as usize * count).div_ceil(100)
}
