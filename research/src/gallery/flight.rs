//! A mission flown in lockstep, to be drawn.

use contract::{Brief, MonotonicNs, Record, RunId, Weights};
use hopper::mission::Snapshot;
use hopper_sim::Mission;
use lockstep::PlannerSchedule;
use node::Failure;
use scenario::ResolvedScenario;

use super::SEED;

/// A mission from start to end, by one planner.
pub struct Flight {
    world: ResolvedScenario,
    brief: Brief,
    planner: &'static str,
    route: Vec<Record>,
}

impl Flight {
    /// Flies the built-in scenario; `weights` replace its w1 and w2.
    ///
    /// # Errors
    /// If scenario or planner are unknown.
    pub fn new(scenario: &str, planner: &'static str, weights: Option<[f64; 2]>) -> Result<Self, Failure> {
        let world =
            scenario::load(scenario).and_then(|scenario| scenario.resolve()).map_err(Failure::usage)?;
        let mut brief = Brief { run: RunId(1), ..world.brief.clone() };
        if let Some([safety, information]) = weights {
            brief.weights = Weights { safety, information, ..brief.weights };
        }
        let mission = Mission { brief: brief.clone(), ..Mission::of(&world, SEED) };
        let schedule = PlannerSchedule::single(planner.parse().map_err(Failure::usage)?);
        let mut route = Vec::new();
        lockstep::fly(mission, &schedule, &mut || MonotonicNs(0), &mut |record| route.push(*record))
            .map_err(Failure::usage)?;
        Ok(Self { world, brief, planner, route })
    }

    /// Number of hops from start to end.
    pub fn hops(&self) -> usize {
        self.route.len()
    }

    /// The mission after so many hops.
    pub fn snapshot(&self, hops: usize) -> Snapshot {
        Snapshot::after(&self.world, &self.brief, SEED, &self.route[..hops], self.planner)
    }

    /// A view that shows `snapshot`.
    pub fn view<'a>(&'a self, snapshot: &'a Snapshot, heading: String) -> report::TitledPicture<'a> {
        report::TitledPicture {
            heading,
            layer: report::Layer::Heights,
            picture: snapshot.picture(&self.world, &self.brief, &self.route[..snapshot.hops], &[]),
        }
    }
}
