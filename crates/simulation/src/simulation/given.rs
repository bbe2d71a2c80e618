//! A mission of the caller's.

use contract::RunId;
use hopper_sim::Mission;

use crate::setup::Seat;

/// A mission to be simulated instead of the one that a seed draws, with planners for all of its robots.
#[derive(Clone, Debug)]
pub struct Given {
    /// The mission.
    pub mission: Mission,
    /// Its planner processes.
    pub planners: Vec<Seat>,
}

impl Given {
    /// The `number`th mission of this world: the first, or another run with other draws.
    pub(super) fn mission(&self, number: u64) -> Mission {
        let Mission { mut brief, seed, .. } = self.mission.clone();
        // A scenario has no run: each mission needs one of its own.
        brief.run = RunId(brief.run.0.wrapping_add(u128::from(number) + 1));
        Mission { brief, seed: seed.wrapping_add(number), ..self.mission.clone() }
    }
}
