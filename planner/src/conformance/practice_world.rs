//! Small drawn worlds in which a planner is tried, and the least of a mission in them.

use contract::{
    Account, Action, Branch, Brief, Cell, Collected, Decision, Digest, GradientSource, Grid, Ground, Guard,
    Leader, Leg, Limits, MonotonicNs, MotionParameters, Name, ObservedMap, Origin, Payoff, Pose, Priors,
    Profile, Range, Reading, Robot, RobotId, Robots, RunId, SensorParameters, Soil, SoilMotion, State,
    Timing, Vetoed, Weights,
};
use motion::{Domain, Draw, landing, steps, transition};

/// The numbers of a drawn world are those of this robot, which no mission has.
const DRAWS: RobotId = RobotId(15);

/// Steps after which a practice mission ends.
const STEPS_MAX: u64 = 60;

/// A world: what the planner is told, and what it has to find out.
#[derive(Clone, Debug)]
pub(super) struct PracticeWorld {
    pub(super) brief: Brief,
    pub(super) leg: Leg,
    /// In index order.
    cells: Vec<Ground>,
}

/// Where a practice mission stands.
#[derive(Clone, Debug)]
pub(super) struct Progress {
    pub(super) map: ObservedMap,
    pub(super) state: State,
}

impl PracticeWorld {
    /// A world of 5 to 11 cells a side: rough ground with sand, impassable cells and slopes too steep for a hop.
    pub(super) fn drawn(seed: u64, profile: Profile) -> Self {
        let uniforms = |index: u64| {
            let mut draw = Draw::new(seed, Domain::Motion, DRAWS, Decision(index));
            std::array::from_fn::<f64, 8, _>(|_| draw.uniform())
        };
        let [width, height, sand, rock, x, y, safety, information] = uniforms(0);
        let side = |uniform: f64| 5 + (uniform * 7.0) as u32;
        let grid = grid(side(width), side(height));
        let along = |uniform: f64, side: u32| (uniform * f64::from(side)) as i32;
        let goal = Cell::new(along(x, grid.width), along(y, grid.height));
        let start = Cell::new(grid.width as i32 - 1 - goal.x, grid.height as i32 - 1 - goal.y);
        let ground = |index: usize| {
            let [h, gx, gy, steep, soil, impassable, ..] = uniforms(1 + index as u64);
            let slope = if steep < 0.1 { 2.0 } else { 0.4 };
            Ground {
                height_m: h - 0.5,
                gradient: [slope * (2.0 * gx - 1.0), slope * (2.0 * gy - 1.0)],
                soil: if soil < sand { Soil::Sand } else { Soil::Hard },
                passable: [start, goal].contains(&grid.cell(index)) || impassable > 0.3 * rock,
                ..Ground::FLAT
            }
        };
        let cells = (0..grid.cells()).map(ground).collect();
        Self::new(grid, cells, (start, goal), [safety, information], profile)
    }

    /// A flat hard square of 9 × 9 cells with the start in its middle. With a goal on a diagonal it is its own mirror
    /// image at that diagonal.
    pub(super) fn flat(goal: Cell, profile: Profile) -> Self {
        let grid = grid(9, 9);
        Self::new(grid, vec![Ground::FLAT; grid.cells()], (Cell::new(4, 4), goal), [0.5, 0.5], profile)
    }

    /// With the constants of Sakamoto & Kunii 2023.
    fn new(
        grid: Grid,
        cells: Vec<Ground>,
        (start, goal): (Cell, Cell),
        [safety, information]: [f64; 2],
        profile: Profile,
    ) -> Self {
        let motion = MotionParameters {
            hard: SoilMotion { intended: 0.9, stuck: 0.0, sideways: 0.05, flights: 1 },
            sand: SoilMotion { intended: 0.7, stuck: 0.1, sideways: 0.1, flights: 2 },
            slope_limit_rad: std::f64::consts::FRAC_PI_6,
            launch_angle_rad: std::f64::consts::FRAC_PI_4,
            gravity_mps2: 3.72,
            vertical: false,
            table: 0,
        };
        let sensor = SensorParameters {
            gain: 2.0,
            offset_m: 1.0,
            radius_min_m: 1.0,
            radius_max_m: 3.0,
            gradient: GradientSource::Measured,
        };
        let hopper = Robot::hopper(&grid, motion, sensor, [start, goal]);
        let brief = Brief {
            run: RunId(1),
            scenario: Name::NONE,
            scenario_hash: [0; 32],
            profile,
            grid,
            datum_m: 0.0,
            weights: Weights { safety, information, distance: 10.0 },
            payoff: Payoff { goal: 100.0, treasure: 10.0, discount: 0.99, sand_term: -5.0 },
            priors: Priors {
                safety: Range { min: -3.0, max: 5.0 },
                height_m: Range { min: -0.5, max: 0.5 },
                treasures: 0,
            },
            limits: Limits { steps_max: STEPS_MAX, decision_budget_ns: 600_000_000 },
            guard: Guard::OFF,
            reading: Reading::default(),
            account: Account::Hopper,
            sampling: None,
            robots: Robots::new(&[hopper]).expect("one robot is enough"),
        };
        Self { brief: brief.clone(), leg: brief.leg(0), cells }
    }

    /// A mission before its first decision.
    pub(super) fn begin(&self) -> Progress {
        let Leg { run, grid, start, .. } = self.leg;
        let state = State {
            run,
            robot: RobotId(0),
            decision: Decision(0),
            steps: 0,
            visits: 0,
            status: contract::Status::Underway,
            leader: Leader::default(),
            pose: Pose { cell: start, height_m: self.ground(start).map_or(0.0, |ground| ground.height_m) },
            collected: Collected::default(),
            vetoed: Vetoed::NONE,
            last: None,
            last_origin: Origin::Planner,
            last_vetoed: Vetoed::NONE,
            previous: Digest::default(),
            digest: Digest::default(),
            landed: MonotonicNs(0),
            published: MonotonicNs(0),
            last_timing: Timing::default(),
        };
        let mut progress = Progress { map: ObservedMap::unseen(run, RobotId(0), grid), state };
        self.sense(&mut progress.map, start);
        progress
    }

    /// Carries `action` out, with the slips of `seed`; `None` once the mission is over.
    pub(super) fn act(&self, mut progress: Progress, action: Action, seed: u64) -> Option<Progress> {
        let Progress { map, state } = &mut progress;
        let ground = *self.ground(state.pose.cell)?;
        let (branch, cell) = match action.hop() {
            Some(direction) => {
                let uniform = Draw::new(seed, Domain::Motion, RobotId(0), state.decision).uniform();
                let branch = transition(&self.leg.motion, &ground, direction).branch(uniform);
                (branch, landing(&self.leg.grid, state.pose.cell, direction, branch))
            }
            None => (Branch::Held, state.pose.cell),
        };
        state.steps += steps(ground.soil, action, branch);
        state.decision = Decision(state.decision.0 + 1);
        let ground = self.ground(cell).filter(|ground| ground.passable)?;
        state.pose = Pose { cell, height_m: ground.height_m };
        self.sense(map, cell);
        (state.steps < STEPS_MAX && cell != self.leg.goal).then_some(progress)
    }

    fn ground(&self, cell: Cell) -> Option<&Ground> {
        self.cells.get(self.brief.grid.index(cell)?)
    }

    /// Writes down what can be seen from `cell`.
    fn sense(&self, map: &mut ObservedMap, from: Cell) {
        let height_m = self.ground(from).map_or(0.0, |ground| ground.height_m);
        let reach_cells = self.leg.sensor.reach_cells(&self.leg.grid, height_m);
        for (index, ground) in self.cells.iter().enumerate() {
            if self.brief.grid.cell(index).distance_cells(from) <= reach_cells {
                map.learn(index, *ground);
            }
        }
        map.mark();
    }
}

fn grid(width: u32, height: u32) -> Grid {
    Grid::new(width, height, 1.0, 1).expect("a small grid of one-metre cells")
}
