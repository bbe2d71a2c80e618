//! The true ground of a run, and how it travels: in pages, once, to whoever may see it.

use serde::{Deserialize, Serialize};

use super::gathering::Gathering;
use crate::{Cell, Grid, Ground, MonotonicNs, Refusal, RunId};

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

/// Gathers the truth of one run page by page, asking until it is whole.
#[derive(Clone, Debug, Default)]
pub struct TruthGathering(Gathering<Ground>);

impl TruthGathering {
    /// Begins to gather the truth of `run`, and forgets any other.
    pub fn begin(&mut self, run: RunId) {
        self.0.begin(run);
    }

    /// Takes a page; the truth once it is whole, which is handed out once.
    ///
    /// # Errors
    /// If the page makes no progress, or goes beyond its grid.
    pub fn page(&mut self, page: TruthPage) -> Result<Option<Truth>, Refusal> {
        let TruthPage { run, grid, from, cells, treasures } = page;
        let whole = self.0.page("truth.cells", (run, &grid, from), cells)?;
        Ok(whole.map(|cells| Truth { run, grid, cells, treasures }))
    }

    /// What to ask for at `now`: the next page, or the same again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<TruthRequest> {
        self.0.ask(now).map(|(run, from)| TruthRequest { run, from })
    }
}
