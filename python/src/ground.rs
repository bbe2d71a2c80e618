//! The ground that the missions of a batch share, with what every cell of it determines.

use std::sync::{Arc, OnceLock};

use contract::{
    Action, Brief, Cell, Digest, Direction, Leader, MonotonicNs, Origin, Pose, Record, Timing, Vetoed,
};
use hopper_sim::dynamics::execute;
use hopper_sim::{Arbiter, Guard, Mission, Pace, ROBOT};
use motion::{Transition, transition};

use crate::trial::Trial;

/// Planes of an observation: height, sand, impassable, seen.
pub const PLANES: usize = 4;

/// What the missions share.
pub struct Ground {
    pub mission: Mission,
    height_m: Vec<f32>,
    sand: Vec<f32>,
    impassable: Vec<f32>,
    /// How hops from each cell scatter, north, east, south, west.
    pub scatter: Vec<[Transition; 4]>,
    pub vetoed: Vec<Vetoed>,
    /// Cells seen from each cell; empty where no hopper has been yet.
    seen_from: Vec<OnceLock<Arc<[u32]>>>,
}

impl Ground {
    /// The ground of `mission`, whatever its seed.
    pub fn new(mission: Mission) -> Self {
        let Mission { brief, terrain, .. } = &mission;
        let finite = |height_m: f64| if height_m.is_finite() { height_m as f32 } else { 0.0 };
        let flag = |is: bool| f32::from(u8::from(is));
        let vetoed = |index: usize| {
            let cell = brief.grid.cell(index);
            let pose = Pose { cell, height_m: terrain.cells[index].height_m };
            let guard = Guard::new(brief, terrain, ROBOT, pose);
            let hops = Direction::ALL.map(Action::Hop).into_iter();
            hops.filter(|&hop| guard.veto(hop).is_some()).fold(Vetoed::NONE, Vetoed::with)
        };
        let is_guarded = brief.guard.hazard_max < 1.0;
        let cells = terrain.cells.len();
        Self {
            height_m: terrain.cells.iter().map(|ground| finite(ground.height_m)).collect(),
            sand: terrain.cells.iter().map(|ground| flag(ground.soil == contract::Soil::Sand)).collect(),
            impassable: terrain.cells.iter().map(|ground| flag(!ground.passable)).collect(),
            scatter: terrain
                .cells
                .iter()
                .map(|ground| Direction::ALL.map(|hop| transition(&brief.motion, ground, hop)))
                .collect(),
            vetoed: (0..cells).map(|index| if is_guarded { vetoed(index) } else { Vetoed::NONE }).collect(),
            seen_from: (0..cells).map(|_| OnceLock::new()).collect(),
            mission,
        }
    }

    /// The brief of the missions.
    pub fn brief(&self) -> &Brief {
        &self.mission.brief
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
            let cells = perception::sensing::disc(brief.grid, &brief.sensor, pose);
            cells.filter_map(|cell| Some(brief.grid.index(cell)? as u32)).collect()
        })
    }

    /// Rows and columns of a plane that is `side` cells wide; 0 for the whole map.
    pub fn shape(&self, side: usize) -> (usize, usize) {
        match side {
            0 => (self.brief().grid.height as usize, self.brief().grid.width as usize),
            side => (side, side),
        }
    }

    /// Writes the planes around the hopper: rows from south to north. What lies beyond the grid is seen and impassable.
    pub fn window(&self, trial: &Trial, side: usize, planes: &mut [f32]) {
        let grid = self.brief().grid;
        let (width, height) = (grid.width as i32, grid.height as i32);
        let (rows, columns) = self.shape(side);
        let (west, south) = match side {
            0 => (0, 0),
            side => (trial.cell.x - side as i32 / 2, trial.cell.y - side as i32 / 2),
        };
        let size = rows * columns;
        let (heights, rest) = planes.split_at_mut(size);
        let (sand, rest) = rest.split_at_mut(size);
        let (impassable, seen) = rest.split_at_mut(size);
        heights.fill(0.0);
        sand.fill(0.0);
        impassable.fill(1.0);
        seen.fill(1.0);
        let first = (-west).max(0);
        let count = (width - west).min(columns as i32) - first;
        if count <= 0 {
            return;
        }
        let (first, count) = (first as usize, count as usize);
        for row in 0..rows {
            let y = south + row as i32;
            if !(0..height).contains(&y) {
                continue;
            }
            let from = (y * width + west + first as i32) as usize;
            let to = row * columns + first;
            let here = &trial.seen[from..from + count];
            for at in 0..count {
                heights[to + at] = self.height_m[from + at] * here[at];
                sand[to + at] = self.sand[from + at] * here[at];
                impassable[to + at] = self.impassable[from + at] * here[at];
                seen[to + at] = here[at];
            }
        }
    }

    /// The digest of the actions of `trial` by hopper-sim's own dynamics; `None` if they lead elsewhere.
    pub fn digest(&self, trial: &Trial) -> Option<Digest> {
        let mission = &Mission { seed: trial.seed, ..self.mission.clone() };
        let now = MonotonicNs(0);
        let mut state = *Arbiter::new(mission.clone(), None, Pace::Max, 0, now).state();
        for &action in &trial.actions {
            let execution = execute(mission, &state, action);
            let mut record = Record {
                robot: ROBOT,
                decision: state.decision,
                leader: Leader::default(),
                action,
                origin: Origin::Planner,
                vetoed: Vetoed::NONE,
                observation: 0,
                work: 0,
                cut: false,
                outcome: execution.outcome,
                pose: execution.pose,
                collected: execution.collected,
                visits: execution.visits,
                steps: execution.steps,
                status: execution.status,
                timing: Timing::default(),
                previous: state.digest,
                digest: state.digest,
            };
            record.digest = state.digest.chain(&record);
            state = record.state_after(mission.brief.run, now, now);
        }
        let same = (state.pose.cell, state.steps, state.collected, state.status)
            == (trial.cell, trial.steps, trial.collected, trial.status);
        same.then_some(state.digest)
    }

    /// Cells of the treasures that `trial` has seen and not collected.
    pub fn treasures_in_sight(&self, trial: &Trial) -> impl Iterator<Item = Cell> {
        let treasures = self.mission.terrain.treasures.iter().enumerate();
        treasures.filter_map(|(number, &cell)| {
            let is_seen = self.brief().grid.index(cell).is_some_and(|index| trial.seen[index] > 0.0);
            (is_seen && trial.collected.0 & 1 << number == 0).then_some(cell)
        })
    }
}
