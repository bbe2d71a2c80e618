//! The expected speeds of uncertain ground: the prior is gathered once, page by page, as planners gather it.

use contract::{Brief, MonotonicNs, PriorPage, PriorRequest, Robot};
use follow::PriorFollower;
use speed_layer::SpeedLayer;

/// The prior of a run until it is whole, and what displays need of it from then on.
#[derive(Debug, Default)]
pub(super) struct Speeds {
    prior: PriorFollower,
    layer: Option<SpeedLayer>,
}

impl Speeds {
    /// Asks for the prior of the brief's run from now on, if its ground is uncertain.
    pub fn begin(&mut self, brief: &Brief) {
        self.prior.begin(brief);
    }

    /// The layer, once the prior is whole.
    pub fn layer(&self) -> Option<&SpeedLayer> {
        self.layer.as_ref()
    }

    /// What to ask for at `now`.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<PriorRequest> {
        self.prior.ask(now)
    }

    /// Adds a page that was asked for; the last one completes the layer. An impossible page is asked for again. Of `robots` only
    /// the cameras matter.
    pub fn page(&mut self, page: PriorPage, robots: &[Robot]) {
        let _ = self.prior.page(page);
        if let Some(prior) = self.prior.take() {
            self.layer = Some(SpeedLayer::new(&prior.cells, robots));
        }
    }
}
