//! How a reader gathers what is served in pages: of every cell of a lattice, or of every class of a table.

use contract::{MonotonicNs, Refusal, RunId};

use crate::page_cursor::PageCursor;

/// Gathers a value for every cell of one run's lattice page by page, asking until all are there.
#[derive(Clone, Debug)]
pub(crate) struct Gathering<C> {
    run: Option<RunId>,
    cells: Vec<C>,
    cursor: PageCursor,
    /// Whether all cells have been handed out.
    is_whole: bool,
}

impl<C> Default for Gathering<C> {
    fn default() -> Self {
        Self { run: None, cells: Vec::new(), cursor: PageCursor::default(), is_whole: false }
    }
}

impl<C: Copy> Gathering<C> {
    /// Begins to gather for `run`, and forgets any other; the same run again changes nothing.
    pub fn begin(&mut self, run: RunId) {
        if self.run != Some(run) {
            *self = Self { run: Some(run), ..Self::default() };
        }
    }

    /// Whether cells of the run are missing.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        self.run.is_some() && !self.is_whole
    }

    /// Takes the cells of a page that begins at index `from`; all cells in index order once they are there, which are
    /// handed out once. A page of another run or place changes nothing. `field` names the cells in a refusal.
    ///
    /// # Errors
    /// If the page makes no progress, or goes beyond the `whole`, all cells there are.
    pub fn page(
        &mut self,
        field: &str,
        (run, whole, from): (RunId, usize, u32),
        mut cells: Vec<C>,
    ) -> Result<Option<Vec<C>>, Refusal> {
        if self.run != Some(run) || self.is_whole || u64::from(from) != self.cursor.next() {
            return Ok(None);
        }
        let missing = whole.saturating_sub(self.cells.len());
        if cells.is_empty() || cells.len() > missing {
            return Err(Refusal::malformed(field, &format!("1 to {missing} more cells"), cells.len()));
        }
        let is_last = cells.len() == missing;
        if self.cells.is_empty() && is_last {
            // A page that is all there is needs no copy.
            self.cells = cells;
        } else {
            self.cells.reserve_exact(missing);
            self.cells.append(&mut cells);
        }
        self.cursor.accept(from.into(), self.cells.len() as u64);
        if !is_last {
            return Ok(None);
        }
        self.is_whole = true;
        Ok(Some(std::mem::take(&mut self.cells)))
    }

    /// The run and the first index to ask for at `now`: the next page, or the same again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<(RunId, u32)> {
        if self.is_whole {
            return None;
        }
        Some((self.run?, self.cursor.ask(now)? as u32))
    }
}
