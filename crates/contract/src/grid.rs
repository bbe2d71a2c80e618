//! The lattice of cells, north-up: x grows east, y grows north, cell (0, 0) is the south-west corner.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::Direction;
use crate::limits::{CELL_SIZE_MIN_M, GRID_CELLS_MAX, GRID_SIDE_MAX, LENGTH_MAX_M};

/// A cell of the grid, possibly outside of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Cell {
    /// Column, eastwards.
    pub x: i32,
    /// Row, northwards.
    pub y: i32,
}

impl Cell {
    /// The cell at column `x`, row `y`.
    #[must_use]
    pub const fn new(x: i32, y: i32) -> Self {
        Self { x, y }
    }

    /// Euclidean distance to `other` in cells.
    #[must_use]
    pub fn distance_cells(self, other: Cell) -> f64 {
        let dx = f64::from(self.x) - f64::from(other.x);
        let dy = f64::from(self.y) - f64::from(other.y);
        (dx * dx + dy * dy).sqrt()
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

/// Why a [`Grid`] is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridError {
    /// A side is zero or too long, or there are too many cells.
    #[error(
        "a grid needs sides of 1 to {GRID_SIDE_MAX} cells and at most {GRID_CELLS_MAX} cells, got {width} x {height}"
    )]
    Size {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// The cell size is not a length.
    #[error("a cell needs a size of {CELL_SIZE_MIN_M} to {LENGTH_MAX_M} m, got {got_m} m")]
    CellSize {
        /// The size asked for.
        got_m: f64,
    },
    /// The hop is not a whole number of cells.
    #[error("a hop needs to span 1 to {GRID_SIDE_MAX} cells, got {got}")]
    HopCells {
        /// The span asked for.
        got: u32,
    },
}

/// Shape and scale of the lattice, with the length of one hop on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Columns, 1 to [`GRID_SIDE_MAX`].
    pub width: u32,
    /// Rows, 1 to [`GRID_SIDE_MAX`].
    pub height: u32,
    /// Edge of a square cell in metres.
    pub cell_size_m: f64,
    /// Cells that one hop spans, at least 1.
    pub hop_cells: u32,
}

impl Grid {
    /// A grid whose fields have been checked.
    ///
    /// # Errors
    /// [`GridError`] names the field, what it needed and what it got.
    pub fn new(width: u32, height: u32, cell_size_m: f64, hop_cells: u32) -> Result<Self, GridError> {
        let sides = 1..=GRID_SIDE_MAX;
        if !sides.contains(&width) || !sides.contains(&height) || width * height > GRID_CELLS_MAX {
            return Err(GridError::Size { width, height });
        }
        if !(CELL_SIZE_MIN_M..=LENGTH_MAX_M).contains(&cell_size_m) {
            return Err(GridError::CellSize { got_m: cell_size_m });
        }
        if !sides.contains(&hop_cells) {
            return Err(GridError::HopCells { got: hop_cells });
        }
        Ok(Self { width, height, cell_size_m, hop_cells })
    }

    /// Width × height.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Length of one hop in metres.
    #[must_use]
    pub fn hop_distance_m(&self) -> f64 {
        f64::from(self.hop_cells) * self.cell_size_m
    }

    /// Whether `cell` lies on the grid.
    #[must_use]
    #[inline]
    pub fn contains(&self, cell: Cell) -> bool {
        (0..self.width as i32).contains(&cell.x) && (0..self.height as i32).contains(&cell.y)
    }

    /// Row-major index of `cell`, southernmost row first; `None` outside.
    #[must_use]
    #[inline]
    pub fn index(&self, cell: Cell) -> Option<usize> {
        self.contains(cell).then(|| cell.y as usize * self.width as usize + cell.x as usize)
    }

    /// The cell at row-major `index`.
    ///
    /// # Panics
    /// If `index` is not below [`Grid::cells`].
    #[must_use]
    #[inline]
    pub fn cell(&self, index: usize) -> Cell {
        assert!(index < self.cells(), "cell index {index} of {}", self.cells());
        Cell::new((index % self.width as usize) as i32, (index / self.width as usize) as i32)
    }

    /// All cells in index order.
    pub fn iter(&self) -> impl Iterator<Item = Cell> + '_ {
        (0..self.cells()).map(|index| self.cell(index))
    }

    /// Where a hop from `from` towards `direction` is meant to land; may lie outside.
    #[must_use]
    pub fn hop(&self, from: Cell, direction: Direction) -> Cell {
        let (dx, dy) = direction.step();
        let span = self.hop_cells as i32;
        Cell::new(from.x + dx * span, from.y + dy * span)
    }

    /// Whether hops can lead from `from` to `to`: their offsets are whole multiples of a hop.
    #[must_use]
    pub fn on_same_lattice(&self, from: Cell, to: Cell) -> bool {
        let span = self.hop_cells as i32;
        (from.x - to.x) % span == 0 && (from.y - to.y) % span == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_and_cell_are_inverse() {
        let grid = Grid::new(7, 3, 1.0, 1).unwrap();
        for (index, cell) in grid.iter().enumerate() {
            assert_eq!(grid.index(cell), Some(index));
        }
        assert_eq!(grid.index(Cell::new(7, 0)), None);
        assert_eq!(grid.index(Cell::new(0, -1)), None);
    }

    #[test]
    fn a_grid_out_of_bounds_is_refused() {
        assert!(Grid::new(0, 5, 1.0, 1).is_err());
        assert!(Grid::new(GRID_SIDE_MAX + 1, 1, 1.0, 1).is_err());
        assert!(Grid::new(5, 5, f64::NAN, 1).is_err());
        assert!(Grid::new(5, 5, 1.0, 0).is_err());
    }

    #[test]
    fn a_hop_of_two_cells_keeps_to_its_lattice() {
        let grid = Grid::new(9, 9, 0.5, 2).unwrap();
        assert_eq!(grid.hop(Cell::new(1, 1), Direction::North), Cell::new(1, 3));
        assert!(grid.on_same_lattice(Cell::new(1, 1), Cell::new(7, 3)));
        assert!(!grid.on_same_lattice(Cell::new(1, 1), Cell::new(2, 3)));
        assert_eq!(grid.hop_distance_m(), 1.0);
    }
}
