//! Many missions side by side, for learners: the dynamics of hopper-sim without processes, maps or journals.
//!
//! A step looks everything up that a cell determines (what is seen from there, how hops scatter, what the guard vetoes),
//! and draws as hopper-sim does. The digest is computed on request, by hopper-sim's own dynamics over the actions taken, so
//! it also proves the tables.

use std::rc::Rc;

use contract::{
    Action, Brief, Cell, Collected, Decision, Digest, Direction, Leader, MonotonicNs, Origin, Pose, Record,
    RobotId, Status, Task, Timing, Vetoed,
};
use hopper_sim::dynamics::execute;
use hopper_sim::{Arbiter, Guard, Mission, Pace, ROBOT};
use motion::{Domain, Draw, Transition, landing, steps, transition};
use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;

/// Planes of an observation: height, sand, impassable, seen.
const PLANES: usize = 4;

/// Numbers beside the planes: x, y, cells to the goal along x and y, share of the steps left.
const NUMBERS: usize = 5;

/// Missions over one scenario, each at its own decision.
#[pyclass(unsendable, module = "hopper")]
pub struct Batch {
    ground: Ground,
    /// Cells of a window's side; 0 for the whole map.
    window: usize,
    envs: Vec<Env>,
}

/// What the missions share.
struct Ground {
    mission: Mission,
    height_m: Vec<f32>,
    sand: Vec<f32>,
    impassable: Vec<f32>,
    /// How hops from each cell scatter, north, east, south, west.
    scatter: Vec<[Transition; 4]>,
    vetoed: Vec<Vetoed>,
    /// Cells seen from each cell; `None` where no hopper has been yet.
    seen_from: Vec<Option<Rc<[u32]>>>,
    start: Cell,
}

struct Env {
    seed: u64,
    cell: Cell,
    steps: u64,
    collected: Collected,
    status: Status,
    /// 1 where seen, else 0.
    seen: Vec<f32>,
    actions: Vec<Action>,
}

#[pymethods]
impl Batch {
    /// `count` missions of a scenario, not begun.
    #[new]
    fn new(scenario: &str, profile: Option<&str>, count: usize, window: usize) -> PyResult<Self> {
        let world = crate::mission::world(scenario, profile)?;
        if world.brief.task() != Task::Reach {
            let name = world.brief.scenario;
            return Err(crate::error(format!(
                "an environment needs a mission of one goal, got scenario {name}"
            )));
        }
        if window != 0 && window.is_multiple_of(2) || window > 255 || count == 0 {
            return Err(crate::error(format!(
                "an environment needs an odd window of 1 to 255 cells, or 0, and a mission; got {window}, and {count} missions"
            )));
        }
        let mission = Mission { brief: world.brief, terrain: world.terrain, seed: 0, fleet: None };
        let ground = Ground::new(mission);
        let envs = (0..count).map(|_| Env::new(&ground)).collect();
        Ok(Self { ground, window, envs })
    }

    /// Rows and columns of a plane.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        match self.window {
            0 => (self.ground.brief().grid.height as usize, self.ground.brief().grid.width as usize),
            side => (side, side),
        }
    }

    /// Columns, rows, steps until the mission is a deadlock.
    #[getter]
    fn limits(&self) -> (u32, u32, u64) {
        let Brief { grid, limits, .. } = self.ground.brief();
        (grid.width, grid.height, limits.steps_max)
    }

    /// Begins mission `index` with `seed`.
    fn reset(&mut self, index: usize, seed: u64) -> PyResult<()> {
        let env = self.envs.get_mut(index).ok_or_else(|| crate::error(format!("no mission {index}")))?;
        env.begin(&mut self.ground, seed);
        Ok(())
    }

    /// Takes one action in every mission. One that is over begins anew instead, with the next seed, and pays nothing.
    /// `rewards` are 64-bit floats, `ends` bytes: 1 for terminated, 2 for truncated.
    fn step(
        &mut self,
        py: Python<'_>,
        actions: &Bound<'_, PyAny>,
        rewards: &Bound<'_, PyAny>,
        ends: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let actions: PyBuffer<i64> = buffer(actions, self.envs.len())?;
        let (rewards, ends) =
            (buffer::<f64>(rewards, self.envs.len())?, buffer::<u8>(ends, self.envs.len())?);
        let (Some(actions), Some(rewards), Some(ends)) =
            (actions.as_slice(py), rewards.as_mut_slice(py), ends.as_mut_slice(py))
        else {
            return Err(crate::error(
                "actions, rewards and ends need to be contiguous, the last two writable",
            ));
        };
        for (index, env) in self.envs.iter_mut().enumerate() {
            if env.status.is_over() {
                env.begin(&mut self.ground, next_seed(env.seed));
                rewards[index].set(0.0);
                ends[index].set(0);
                continue;
            }
            let code = actions[index].get();
            let action = u32::try_from(code).ok().and_then(Action::from_code);
            let Some(action) = action.filter(|action| !matches!(action, Action::Step(_))) else {
                return Err(crate::error(format!("an action needs to be 0 to 4, got {code}")));
            };
            rewards[index].set(env.act(&mut self.ground, action));
            ends[index].set(match env.status {
                Status::Underway => 0,
                Status::Deadlock => 2,
                _ => 1,
            });
        }
        Ok(())
    }

    /// Writes what every mission shows into arrays of 32-bit floats: planes, and numbers.
    fn observe(&self, py: Python<'_>, planes: &Bound<'_, PyAny>, numbers: &Bound<'_, PyAny>) -> PyResult<()> {
        let (rows, columns) = self.shape();
        let size = PLANES * rows * columns;
        let (planes, numbers) = (
            buffer::<f32>(planes, self.envs.len() * size)?,
            buffer::<f32>(numbers, self.envs.len() * NUMBERS)?,
        );
        let (Some(planes), Some(numbers)) = (planes.as_mut_slice(py), numbers.as_mut_slice(py)) else {
            return Err(crate::error("observations need contiguous, writable arrays"));
        };
        let mut window = vec![0.0; size];
        for ((env, planes), numbers) in
            self.envs.iter().zip(planes.chunks_exact(size)).zip(numbers.chunks_exact(NUMBERS))
        {
            self.ground.window(env, self.window, &mut window);
            planes.iter().zip(&window).for_each(|(to, from)| to.set(*from));
            let Brief { goal, limits, .. } = self.ground.brief();
            let left = limits.steps_max.saturating_sub(env.steps) as f32 / limits.steps_max.max(1) as f32;
            let values =
                [env.cell.x, env.cell.y, goal.x - env.cell.x, goal.y - env.cell.y].map(|value| value as f32);
            numbers.iter().zip(values.into_iter().chain([left])).for_each(|(to, value)| to.set(value));
        }
        Ok(())
    }

    /// Seed, steps, treasures collected and status of a mission.
    fn told(&self, index: usize) -> PyResult<(u64, u64, u32, String)> {
        let env = self.envs.get(index).ok_or_else(|| crate::error(format!("no mission {index}")))?;
        Ok((env.seed, env.steps, env.collected.count(), env.status.to_string()))
    }

    /// The digest of a mission so far, that of the live mission with its seed and its actions.
    fn digest(&mut self, index: usize) -> PyResult<String> {
        let env = self.envs.get(index).ok_or_else(|| crate::error(format!("no mission {index}")))?;
        let digest = self.ground.digest(env);
        digest.map(|digest| digest.to_string()).ok_or_else(|| {
            crate::error("the digest's mission and the environment's differ: this is a defect of hopper")
        })
    }
}

/// The memory of an array of `len` numbers.
fn buffer<T: Element>(array: &Bound<'_, PyAny>, len: usize) -> PyResult<PyBuffer<T>> {
    let buffer = PyBuffer::<T>::get(array)?;
    if buffer.item_count() == len {
        return Ok(buffer);
    }
    Err(crate::error(format!("an array needs {len} numbers, got {}", buffer.item_count())))
}

/// The seed of the mission after that of `seed` (the output function of SplitMix64).
fn next_seed(seed: u64) -> u64 {
    let z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    // Scenario seeds are numbers of 63 bits at most.
    (z ^ (z >> 31)) >> 1
}

impl Ground {
    fn new(mission: Mission) -> Self {
        let Mission { brief, terrain, .. } = &mission;
        let finite = |height_m: f64| if height_m.is_finite() { height_m as f32 } else { 0.0 };
        let flag = |is: bool| f32::from(u8::from(is));
        let vetoed = |index: usize| {
            let cell = brief.grid.cell(index);
            let pose = Pose { cell, height_m: terrain.cells[index].height_m };
            let guard = Guard::new(brief, terrain, hopper_sim::ROBOT, pose);
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
            seen_from: vec![None; cells],
            start: brief.start,
            mission,
        }
    }

    fn brief(&self) -> &Brief {
        &self.mission.brief
    }

    /// Indices of the cells that are seen from the cell at `index`.
    fn seen_from(&mut self, index: usize) -> Rc<[u32]> {
        let Mission { brief, terrain, .. } = &self.mission;
        let seen = self.seen_from[index].get_or_insert_with(|| {
            let pose = Pose { cell: brief.grid.cell(index), height_m: terrain.cells[index].height_m };
            let cells = perception::sensing::disc(brief.grid, &brief.sensor, pose);
            cells.filter_map(|cell| Some(brief.grid.index(cell)? as u32)).collect()
        });
        Rc::clone(seen)
    }

    /// Writes the planes around the hopper: rows from south to north. What lies beyond the grid is seen and impassable.
    fn window(&self, env: &Env, side: usize, planes: &mut [f32]) {
        let grid = self.brief().grid;
        let (width, height) = (grid.width as i32, grid.height as i32);
        let (rows, columns, west, south) = match side {
            0 => (grid.height as usize, grid.width as usize, 0, 0),
            side => (side, side, env.cell.x - side as i32 / 2, env.cell.y - side as i32 / 2),
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
            let here = &env.seen[from..from + count];
            for at in 0..count {
                heights[to + at] = self.height_m[from + at] * here[at];
                sand[to + at] = self.sand[from + at] * here[at];
                impassable[to + at] = self.impassable[from + at] * here[at];
                seen[to + at] = here[at];
            }
        }
    }

    /// The digest of the actions of `env` by hopper-sim's own dynamics; `None` if they lead elsewhere.
    fn digest(&mut self, env: &Env) -> Option<Digest> {
        self.mission.seed = env.seed;
        let (mission, now) = (&self.mission, MonotonicNs(0));
        let mut state = *Arbiter::new(mission.clone(), None, Pace::Max, 0, now).state();
        for &action in &env.actions {
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
            == (env.cell, env.steps, env.collected, env.status);
        same.then_some(state.digest)
    }
}

impl Env {
    fn new(ground: &Ground) -> Self {
        Self {
            seed: 0,
            cell: ground.start,
            steps: 0,
            collected: Collected::default(),
            // The first step begins a mission.
            status: Status::Deadlock,
            seen: vec![0.0; ground.height_m.len()],
            actions: Vec::new(),
        }
    }

    fn begin(&mut self, ground: &mut Ground, seed: u64) {
        self.seed = seed;
        (self.cell, self.steps, self.collected) = (ground.start, 0, Collected::default());
        self.status = hopper_sim::mission::opening_status(ground.brief());
        self.seen.fill(0.0);
        self.actions.clear();
        self.look(ground);
    }

    /// Sees what can be seen from the hopper's cell.
    fn look(&mut self, ground: &mut Ground) {
        if let Some(index) = ground.brief().grid.index(self.cell) {
            ground.seen_from(index).iter().for_each(|&index| self.seen[index as usize] = 1.0);
        }
    }

    /// Carries `action` out, or holds where the guard vetoes it; the reward.
    fn act(&mut self, ground: &mut Ground, action: Action) -> f64 {
        let Some(index) = ground.brief().grid.index(self.cell) else { return 0.0 };
        let action = if ground.vetoed[index].has(action) { Action::Hold } else { action };
        let decision = Decision(self.actions.len() as u64);
        let brief = ground.brief();
        let (branch, cell) = match action {
            Action::Hop(direction) => {
                let uniform = Draw::new(self.seed, Domain::Motion, RobotId(0), decision).uniform();
                let branch = ground.scatter[index][direction as usize].branch(uniform);
                (branch, landing(&brief.grid, self.cell, direction, branch))
            }
            _ => (contract::Branch::Held, self.cell),
        };
        let terrain = &ground.mission.terrain;
        let cost = steps(terrain.cells[index].soil, action, branch);
        let collected = self.collected.landing(&terrain.treasures, cell);
        let treasures = f64::from(collected.count() - self.collected.count());
        self.steps += cost;
        (self.cell, self.collected) = (cell, collected);
        self.actions.push(action);
        self.status = match terrain.ground(cell) {
            _ if cell == brief.goal && self.steps <= brief.limits.steps_max => Status::Goal,
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
}
