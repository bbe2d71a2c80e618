//! One mission of a batch.

use contract::{
    Action, Branch, Cell, Collected, Decision, Digest, Direction, Leader, Leg, MonotonicNs, Origin, Record,
    RobotId, Status, Timing, Vetoed,
};
use hopper_sim::{Arbiter, Mission, Pace, ROBOT, RobotTeam};
use motion::{Domain, Draw, landing, steps};

use crate::ground::Ground;

/// A mission at its own decision.
#[derive(Clone)]
pub struct Trial {
    pub seed: u64,
    /// Whether it was ever begun.
    pub begun: bool,
    pub cell: Cell,
    pub steps: u64,
    pub collected: Collected,
    pub status: Status,
    /// 1 where seen, else 0.
    pub seen: Vec<f32>,
    /// What was done so far; what the guard vetoed is a hold.
    pub actions: Vec<Action>,
    /// The cells it has been on, the start included.
    pub route: Vec<Cell>,
}

impl Trial {
    /// A mission that has not begun.
    pub fn new(ground: &Ground) -> Self {
        Self {
            seed: 0,
            begun: false,
            cell: ground.leg().start,
            steps: 0,
            collected: Collected::default(),
            status: Status::Underway,
            seen: vec![0.0; ground.cells()],
            actions: Vec::new(),
            route: Vec::new(),
        }
    }

    /// Begins the mission of `seed`.
    pub fn begin(&mut self, ground: &Ground, seed: u64) {
        (self.seed, self.begun) = (seed, true);
        (self.cell, self.steps, self.collected) = (ground.leg().start, 0, Collected::default());
        self.status = hopper_sim::mission::opening_status(ground.brief());
        self.seen.fill(0.0);
        self.actions.clear();
        self.route.clear();
        self.look(ground);
    }

    /// Begins the mission after this one.
    pub fn begin_next(&mut self, ground: &Ground) {
        self.begin(ground, next_seed(self.seed));
    }

    /// Sees what can be seen from the hopper's cell.
    fn look(&mut self, ground: &Ground) {
        self.route.push(self.cell);
        if let Some(index) = ground.brief().grid.index(self.cell) {
            ground.seen_from(index).iter().for_each(|&index| self.seen[index as usize] = 1.0);
        }
    }

    /// Carries `action` out, or holds where the guard vetoes it; the reward.
    pub fn act(&mut self, ground: &Ground, action: Action) -> f64 {
        let Some(index) = ground.brief().grid.index(self.cell) else { return 0.0 };
        let action = if ground.vetoed[index].has(action) { Action::Hold } else { action };
        let decision = Decision(self.actions.len() as u64);
        let brief = ground.brief();
        let (branch, cell) = match action.hop() {
            Some(direction) => {
                let uniform = Draw::new(self.seed, Domain::Motion, RobotId(0), decision).uniform();
                let branch = ground.branch(index, action, direction, uniform);
                (branch, landing(&brief.grid, self.cell, direction, branch))
            }
            None => (Branch::Held, self.cell),
        };
        let terrain = &ground.mission.terrain;
        let cost = steps(terrain.cells[index].soil, action, branch);
        let collected = self.collected.landing(&terrain.treasures, cell);
        let treasures = f64::from(collected.count() - self.collected.count());
        self.steps += cost;
        (self.cell, self.collected) = (cell, collected);
        self.actions.push(action);
        self.status = match terrain.ground(cell) {
            _ if cell == ground.leg().goal && self.steps <= brief.limits.steps_max => Status::Goal,
            None => Status::LeftMap,
            Some(there) if !there.passable => Status::Lost,
            Some(_) if self.steps >= brief.limits.steps_max => Status::Deadlock,
            Some(_) => Status::Underway,
        };
        let end = match self.status {
            Status::Goal => brief.payoff.goal,
            Status::LeftMap | Status::Lost => -brief.payoff.goal,
            _ => 0.0,
        };
        let reward = end + treasures * brief.payoff.treasure - cost as f64;
        self.look(ground);
        reward
    }

    /// x and y of the hopper, cells to the goal along x and y, share of the steps left.
    pub fn numbers(&self, leg: &Leg) -> [f32; 5] {
        let Leg { goal, limits, .. } = leg;
        let left = limits.steps_max.saturating_sub(self.steps) as f32 / limits.steps_max.max(1) as f32;
        let [x, y, to_x, to_y] =
            [self.cell.x, self.cell.y, goal.x - self.cell.x, goal.y - self.cell.y].map(|value| value as f32);
        [x, y, to_x, to_y, left]
    }

    /// Writes the planes around the hopper: rows from south to north. What lies beyond the grid is seen and impassable.
    pub fn window(&self, ground: &Ground, side: usize, planes: &mut [f32]) {
        let grid = ground.brief().grid;
        let (width, height) = (grid.width as i32, grid.height as i32);
        let (rows, columns) = ground.shape(side);
        let (west, south) = match side {
            0 => (0, 0),
            side => (self.cell.x - side as i32 / 2, self.cell.y - side as i32 / 2),
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
            let here = &self.seen[from..from + count];
            for at in 0..count {
                heights[to + at] = ground.height_m[from + at] * here[at];
                sand[to + at] = ground.sand[from + at] * here[at];
                impassable[to + at] = ground.impassable[from + at] * here[at];
                seen[to + at] = here[at];
            }
        }
    }

    /// The digest of what was done by hopper-sim's own dynamics; `None` if they lead elsewhere.
    pub fn digest(&self, ground: &Ground) -> Option<Digest> {
        let mission = &Mission { seed: self.seed, ..ground.mission.clone() };
        let now = MonotonicNs(0);
        let mut state = *Arbiter::new(mission.clone(), None, Pace::Max, 0, now).state();
        let mut team = RobotTeam::new(mission);
        for &action in &self.actions {
            let (_, execution) = team.execute(mission, &state, Leader::default(), action);
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
                detail: execution.detail,
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
            == (self.cell, self.steps, self.collected, self.status);
        same.then_some(state.digest)
    }

    /// Cells of the treasures that it has seen and not collected.
    pub fn treasures_in_sight(&self, ground: &Ground) -> impl Iterator<Item = Cell> {
        let treasures = ground.mission.terrain.treasures.iter().enumerate();
        treasures.filter_map(|(number, &cell)| {
            let is_seen = ground.brief().grid.index(cell).is_some_and(|index| self.seen[index] > 0.0);
            (is_seen && self.collected.0 & 1 << number == 0).then_some(cell)
        })
    }
}

/// The seed of the mission after that of `seed` (the output function of SplitMix64).
fn next_seed(seed: u64) -> u64 {
    let z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    // Random seeds are numbers of 63 bits.
    (z ^ (z >> 31)) >> 1
}
