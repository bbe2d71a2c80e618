//! The ground that the missions of a batch share, with what every cell of it determines.

use std::sync::{Arc, OnceLock};

use contract::{Action, Brief, Cell, Direction, Leg, Pose, Sensor, Vetoed};
use hopper_sim::{Guard, Mission, ROBOT};
use motion::{Transition, clears, offers, transition};

/// Planes of an observation: height, sand, impassable, seen.
pub const PLANES: usize = 4;

/// What the missions share.
pub struct Ground {
    pub mission: Mission,
    leg: Leg,
    pub height_m: Vec<f32>,
    pub sand: Vec<f32>,
    pub impassable: Vec<f32>,
    /// How the hops from each cell are drawn, north, east, south, west.
    pub scatter: Vec<[Transition; 4]>,
    /// How the vertical hops from each cell are drawn, where they are offered; none where the scenario has none.
    pub ups: Vec<[Option<Transition>; 4]>,
    /// Whether a hop from each cell towards a direction, or a slip to it, collides, where the scenario checks it.
    pub collides: Vec<[bool; 4]>,
    pub vetoed: Vec<Vetoed>,
    /// Cells seen from each cell; empty where no hopper has been yet.
    seen_from: Vec<OnceLock<Arc<[u32]>>>,
}

impl Ground {
    /// The ground of `mission`, whatever its seed.
    pub fn new(mission: Mission) -> Self {
        let Mission { brief, terrain, .. } = &mission;
        let leg = brief.leg(0);
        let finite = |height_m: f64| if height_m.is_finite() { height_m as f32 } else { 0.0 };
        let flag = |is: bool| f32::from(u8::from(is));
        let vetoed = |index: usize| {
            let cell = brief.grid.cell(index);
            let pose = Pose { cell, height_m: terrain.cells[index].height_m };
            let guard = Guard::new(brief, terrain, ROBOT, pose);
            let hops = Direction::ALL.map(Action::Hop).into_iter().chain(Direction::ALL.map(Action::Up));
            let hops = hops.filter(|hop| leg.motion.vertical || matches!(hop, Action::Hop(_)));
            hops.filter(|&hop| guard.refusal(hop).is_some()).fold(Vetoed::NONE, Vetoed::with)
        };
        let is_guarded = brief.guard.hazard_max < 1.0 || leg.motion.vertical;
        let is_checked = matches!(mission.dynamics, scenario::Dynamics::Collision(_));
        let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
        let collides = |(cell, ground): (Cell, &contract::Ground)| {
            Direction::ALL.map(|towards| {
                let clears = || clears(&leg.motion, &brief.grid, ground.soil, (cell, towards), height_m);
                is_checked && !clears()
            })
        };
        let ups = |from: (Cell, &contract::Ground)| {
            let offers = offers(&leg.motion, &brief.grid, from, height_m);
            offers.map(|offer| offer.filter(|offer| offer.climb_m.is_some()).map(|offer| offer.drawn))
        };
        let (collides, ups) = (
            brief.grid.iter().zip(&terrain.cells).map(collides).collect(),
            brief.grid.iter().zip(&terrain.cells).map(ups).collect(),
        );
        let cells = terrain.cells.len();
        Self {
            height_m: terrain.cells.iter().map(|ground| finite(ground.height_m)).collect(),
            sand: terrain.cells.iter().map(|ground| flag(ground.soil == contract::Soil::Sand)).collect(),
            impassable: terrain.cells.iter().map(|ground| flag(!ground.passable)).collect(),
            scatter: terrain
                .cells
                .iter()
                .map(|ground| Direction::ALL.map(|hop| transition(&leg.motion, ground, hop)))
                .collect(),
            vetoed: (0..cells).map(|index| if is_guarded { vetoed(index) } else { Vetoed::NONE }).collect(),
            seen_from: (0..cells).map(|_| OnceLock::new()).collect(),
            collides,
            ups,
            leg,
            mission,
        }
    }

    /// The brief of the missions.
    pub fn brief(&self) -> &Brief {
        &self.mission.brief
    }

    /// The leg that their hopper flies.
    pub fn leg(&self) -> &Leg {
        &self.leg
    }

    /// How many cells there are.
    pub fn cells(&self) -> usize {
        self.height_m.len()
    }

    /// Indices of the cells that are seen from the cell at `index`.
    pub fn seen_from(&self, index: usize) -> &[u32] {
        let Mission { brief, terrain, .. } = &self.mission;
        self.seen_from[index].get_or_init(|| {
            let pose = Pose { cell: brief.grid.cell(index), height_m: terrain.cells[index].height_m };
            let seen = perception::sensing::around(brief.grid, Sensor::Disc(self.leg.sensor), pose);
            seen.map(|index| index as u32).collect()
        })
    }

    /// Rows and columns of a plane that is `side` cells wide; 0 for the whole map.
    pub fn shape(&self, side: usize) -> (usize, usize) {
        match side {
            0 => (self.brief().grid.height as usize, self.brief().grid.width as usize),
            side => (side, side),
        }
    }
}
