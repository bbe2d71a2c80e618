//! The true ground of a run, gathered once by whoever may see it.

use contract::{Ground, MonotonicNs, Refusal, RunId, Truth, TruthPage, TruthRequest};

use crate::gathering::Gathering;

/// Gathers the truth of one run page by page, asking until it is whole.
#[derive(Clone, Debug, Default)]
pub struct TruthFollower(Gathering<Ground>);

impl TruthFollower {
    /// Begins to gather the truth of `run`, and forgets any other; the same run again changes nothing.
    pub fn begin(&mut self, run: RunId) {
        self.0.begin(run);
    }

    /// Takes a page; the truth once it is whole, which is handed out once.
    ///
    /// # Errors
    /// If the page makes no progress, or goes beyond its grid.
    pub fn page(&mut self, page: TruthPage) -> Result<Option<Truth>, Refusal> {
        let TruthPage { run, grid, from, cells, treasures } = page;
        let whole = self.0.page("truth.cells", (run, grid.cells(), from), cells)?;
        Ok(whole.map(|cells| Truth { run, grid, cells, treasures }))
    }

    /// What to ask for at `now`: the next page, or the same again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<TruthRequest> {
        self.0.ask(now).map(|(run, from)| TruthRequest { run, from })
    }
}
