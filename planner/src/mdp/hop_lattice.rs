//! The hop lattice: the cells that a hopper can reach by whole hops.

use contract::{Cell, Grid, Leg};

/// The lattice that contains the goal: every `hop_cells`-th cell in both directions, numbered as nodes row by row.
#[derive(Clone, Copy, Debug)]
pub struct HopLattice {
    /// The grid that its cells lie on.
    pub grid: Grid,
    origin: Cell,
    /// Nodes per row.
    pub width: usize,
    /// Number of rows of nodes.
    pub height: usize,
}

impl HopLattice {
    /// The lattice of the leg's goal.
    #[must_use]
    pub fn new(leg: &Leg) -> Self {
        let stride = leg.grid.hop_cells as i32;
        let origin = Cell::new(leg.goal.x.rem_euclid(stride), leg.goal.y.rem_euclid(stride));
        let along = |side: u32, origin: i32| ((side as i32 - origin + stride - 1) / stride) as usize;
        Self {
            grid: leg.grid,
            origin,
            width: along(leg.grid.width, origin.x),
            height: along(leg.grid.height, origin.y),
        }
    }

    /// Number of nodes: width times height.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.width * self.height
    }

    /// The cell of a node.
    #[must_use]
    pub fn cell(&self, node: usize) -> Cell {
        let stride = self.grid.hop_cells as i32;
        let (column, row) = ((node % self.width) as i32, (node / self.width) as i32);
        Cell::new(self.origin.x + column * stride, self.origin.y + row * stride)
    }

    /// The node of a cell; `None` outside the grid or off the lattice.
    #[must_use]
    pub fn node(&self, cell: Cell) -> Option<usize> {
        let stride = self.grid.hop_cells as i32;
        (self.grid.contains(cell) && self.grid.on_same_lattice(cell, self.origin)).then(|| {
            let (column, row) = ((cell.x - self.origin.x) / stride, (cell.y - self.origin.y) / stride);
            row as usize * self.width + column as usize
        })
    }
}
