//! The true ground of a run, and how it travels: in pages, once, to whoever may see it.

use serde::{Deserialize, Serialize};

use crate::{Cell, Grid, Ground, MonotonicNs, PageCursor, Refusal, RunId};

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
pub struct Gathering {
    run: Option<RunId>,
    cells: Vec<Ground>,
    cursor: PageCursor,
}

impl Gathering {
    /// Begins to gather the truth of `run`, and forgets any other.
    pub fn begin(&mut self, run: RunId) {
        *self = Self { run: Some(run), ..Self::default() };
    }

    /// Takes a page; the truth once it is whole, which is handed out once.
    ///
    /// # Errors
    /// If the page makes no progress, or goes beyond its grid.
    pub fn page(&mut self, page: &TruthPage) -> Result<Option<Truth>, Refusal> {
        if self.run != Some(page.run) || u64::from(page.from) != self.cursor.next() {
            return Ok(None);
        }
        let whole = page.grid.cells();
        if page.cells.is_empty() || self.cells.len() + page.cells.len() > whole {
            let need = format!("1 to {} more cells", whole.saturating_sub(self.cells.len()));
            return Err(Refusal::malformed("truth.cells", &need, page.cells.len()));
        }
        self.cells.reserve_exact(whole - self.cells.len());
        self.cells.extend_from_slice(&page.cells);
        self.cursor.accept(page.from.into(), self.cells.len() as u64);
        if self.cells.len() < whole {
            return Ok(None);
        }
        self.run = None;
        let cells = std::mem::take(&mut self.cells);
        Ok(Some(Truth { run: page.run, grid: page.grid, cells, treasures: page.treasures.clone() }))
    }

    /// What to ask for at `now`: the next page, or the same again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<TruthRequest> {
        let run = self.run?;
        Some(TruthRequest { run, from: self.cursor.ask(now)? as u32 })
    }
}
