//! Missions that test the protocol alone: a hopper on flat ground, whose hops land where they are meant to.

use contract::{Body, Ground, Hopper, SoilMotion};
use hopper_sim::Mission;
use terrain::Terrain;

use super::{Vertical, hopper_mission};

/// Every hop lands ahead.
const CERTAIN: SoilMotion = SoilMotion { intended: 1.0, stuck: 0.0, sideways: 0.0, flights: 1 };

/// The guard allows no larger hazard than this, so that it vetoes every hop off the map.
const HAZARD_MAX: f64 = 0.5;

/// The `number`th mission of a seed: that of the hopper missions, on flat ground without treasures.
pub(super) fn mission(seed: u64, number: u64) -> Mission {
    let mut mission =
        Mission { dynamics: Default::default(), ..hopper_mission(seed, number, Vertical::NONE) };
    let grid = mission.brief.grid;
    let cells = vec![Ground::FLAT; grid.cells()];
    mission.terrain = Terrain { grid, cells, treasures: Vec::new(), prior: Vec::new() }.into();
    mission.brief.guard.hazard_max = mission.brief.guard.hazard_max.min(HAZARD_MAX);
    if let Body::Hopper(Hopper { motion }) = &mut mission.brief.robots[0].body {
        motion.hard = CERTAIN;
    }
    mission
}
