//! The expected speeds of uncertain ground: the prior is gathered once, page by page, as planners gather it.

use contract::{Member, MonotonicNs, PriorGathering, PriorPage, PriorRequest, RunId};
use speed_layer::SpeedLayer;

/// The prior of a run until it is whole, and what displays need of it from then on.
#[derive(Debug, Default)]
pub(super) struct Speeds {
    gathering: PriorGathering,
    layer: Option<SpeedLayer>,
}

impl Speeds {
    /// Asks for the prior of `run` from now on.
    pub fn begin(&mut self, run: RunId) {
        self.gathering.begin(run);
    }

    /// The layer, once the prior is whole and the robots are known.
    pub fn layer(&self) -> Option<&SpeedLayer> {
        self.layer.as_ref()
    }

    /// What to ask for at `now`.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<PriorRequest> {
        self.gathering.ask(now)
    }

    /// Adds a page that was asked for. One that cannot be is asked for again.
    pub fn page(&mut self, page: PriorPage) {
        let _ = self.gathering.page(page);
    }

    /// Makes the layer once the prior is whole; of the robots only the cameras count, which never change.
    pub fn complete(&mut self, members: &[Member]) {
        if let Some(prior) = self.gathering.prior() {
            self.layer = Some(SpeedLayer::new(&prior.cells, members));
            self.gathering = PriorGathering::default();
        }
    }
}
