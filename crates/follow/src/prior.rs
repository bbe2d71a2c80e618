//! What is known of uncertain ground before the mission, gathered once.

use contract::{Brief, Grid, MonotonicNs, Prior, PriorCell, PriorPage, PriorRequest, Refusal, RunId};

use crate::gathering::Gathering;

/// Gathers the prior of one run page by page, asking until it is whole.
#[derive(Clone, Debug, Default)]
pub struct PriorFollower {
    /// The run and the lattice whose prior is gathered; `None` where speeds are certain.
    of: Option<(RunId, Grid)>,
    pages: Gathering<PriorCell>,
    prior: Option<Prior>,
}

impl PriorFollower {
    /// Begins to gather the prior of the brief's run, if its ground is uncertain; the same run again changes nothing.
    pub fn begin(&mut self, brief: &Brief) {
        let of = brief.sampling.map(|_| (brief.run, brief.grid));
        if self.of != of {
            *self = Self { of, ..Self::default() };
            self.of.iter().for_each(|(run, _)| self.pages.begin(*run));
        }
    }

    /// The prior, once it is whole and until it is taken.
    #[must_use]
    pub fn prior(&self) -> Option<&Prior> {
        self.prior.as_ref()
    }

    /// Hands the prior out, once.
    pub fn take(&mut self) -> Option<Prior> {
        self.prior.take()
    }

    /// Whether pages of it are missing.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        self.pages.is_missing()
    }

    /// Takes a page that was asked for; one of another run or place changes nothing.
    ///
    /// # Errors
    /// If the page is of another lattice than the brief's, makes no progress, or goes beyond the lattice.
    pub fn page(&mut self, page: PriorPage) -> Result<(), Refusal> {
        let PriorPage { run, grid, from, cells } = page;
        if self.of.is_some_and(|(own, need)| run == own && grid != need) {
            return Err(Refusal::malformed("prior.grid", "the brief's", format!("{grid:?}")));
        }
        if let Some(cells) = self.pages.page("prior.cells", (run, grid.cells(), from), cells)? {
            self.prior = Some(Prior { run, grid, cells });
        }
        Ok(())
    }

    /// What to ask for at `now`: the next page, or the same again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<PriorRequest> {
        self.pages.ask(now).map(|(run, from)| PriorRequest { run, from })
    }
}

#[cfg(test)]
mod tests {
    use contract::SpeedPrior;

    use super::*;

    #[test]
    fn pages_are_gathered_in_order_until_the_prior_is_whole() {
        let grid = Grid::new(3, 2, 1.0, 1).unwrap();
        let speeds = SpeedPrior::new([0.0, 0.0, 0.0, 1.0]).unwrap();
        let cell = PriorCell { speeds, height_m: 0.5 };
        let page = |from, cells| PriorPage { run: RunId(4), grid, from, cells: vec![cell; cells] };
        let mut follower = PriorFollower::default();
        assert_eq!(follower.ask(MonotonicNs(1)), None, "no run yet");
        assert!(!follower.is_missing());
        (follower.of, follower.pages) = (Some((RunId(4), grid)), Gathering::default());
        follower.pages.begin(RunId(4));
        assert_eq!(follower.ask(MonotonicNs(1)), Some(PriorRequest { run: RunId(4), from: 0 }));
        follower.page(page(0, 4)).unwrap();
        follower.page(page(0, 4)).unwrap();
        assert_eq!(follower.ask(MonotonicNs(1)), Some(PriorRequest { run: RunId(4), from: 4 }));
        assert!(follower.page(page(4, 3)).is_err() && follower.page(page(4, 0)).is_err());
        let elsewhere = Grid::new(6, 1, 1.0, 1).unwrap();
        assert!(follower.page(PriorPage { grid: elsewhere, ..page(4, 2) }).is_err());
        assert!(follower.is_missing());
        follower.page(page(4, 2)).unwrap();
        assert!(!follower.is_missing());
        assert_eq!(follower.prior().map(|prior| prior.cells.len()), Some(6));
        assert_eq!(follower.ask(MonotonicNs(u64::MAX)), None);
        assert!(follower.take().is_some() && follower.take().is_none());
        assert!(!follower.is_missing());
    }
}
