//! The ground that the missions of a batch share, with what every cell of it determines.

use std::sync::{Arc, OnceLock};

use contract::{Action, Branch, Brief, Direction, Leg, Pose, Sensor, Vetoed};
use hopper_sim::{Guard, Mission, ROBOT};
use motion::{Transition, transition};

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
    scatter: Vec<[Transition; 4]>,
    /// Whether hops collide.
    is_checked: bool,
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
            is_checked,
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

    /// The branch of a hop from the cell at `index`, by a number that is uniform in [0, 1).
    pub fn branch(&self, index: usize, hop: Action, direction: Direction, uniform: f64) -> Branch {
        if !self.is_checked {
            return self.scatter[index][direction as usize].branch(uniform);
        }
        let Mission { brief, terrain, .. } = &self.mission;
        let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
        let from = (brief.grid.cell(index), &terrain.cells[index]);
        let offer = motion::checked(&self.leg.motion, &brief.grid, from, hop, height_m);
        offer.map_or(Branch::Stayed, |offer| offer.branch(uniform).0)
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
