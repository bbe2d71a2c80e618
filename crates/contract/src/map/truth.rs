//! The true ground of a run, and how it travels: in pages, once, to whoever may see it.

use serde::{Deserialize, Serialize};

use crate::{Cell, Grid, Ground, RunId};

/// The true ground of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Lattice of the mission; every cell of the message lies on it.
    pub grid: Grid,
    /// Cells in index order.
    pub cells: Vec<Ground>,
    /// Cells with treasures in index order.
    pub treasures: Vec<Cell>,
}

/// Asks hopper-sim for the truth from an index on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TruthRequest {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// First index wanted.
    pub from: u32,
}

/// Consecutive cells of the truth, at most [`crate::limits::TRUTH_PAGE_CELLS`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthPage {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Lattice of the mission; every cell of the message lies on it.
    pub grid: Grid,
    /// Index of the first cell.
    pub from: u32,
    /// Cells in index order.
    pub cells: Vec<Ground>,
    /// Cells with treasures anywhere on the lattice, in index order.
    pub treasures: Vec<Cell>,
}
