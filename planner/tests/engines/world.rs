//! Worlds to plan in, with the truth that the planner does not see, and a minimal episode loop.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_6, PI};

use contract::{
    Account, Action, Branch, Brief, Cell, Decision, Digest, GradientSource, Grid, Ground, Leader, Leg,
    Limits, MonotonicNs, MotionParameters, Name, ObservedMap, Payoff, Pose, Priors, Profile, Range, Robot,
    RobotId, Robots, RunId, SensorParameters, Soil, SoilMotion, State, Status, Timing, Weights,
};
use motion::{Domain, Draw, landing, steps};
use planner::{Budget, Plan, Planner, Situation};

/// The three soils of P23.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Soils {
    /// Hard everywhere.
    Hard,
    /// Sand where 5 ≤ x ≤ 11 and 3 ≤ y ≤ 11.
    Heterogeneous,
    /// Sand wherever h < 0.1 m.
    Sandy,
}

/// A world: the leg of a hopper, and the ground.
#[derive(Clone, Debug)]
pub struct World {
    /// Planners for one hopper do not read it.
    brief: Brief,
    /// What the planner is told.
    pub leg: Leg,
    /// The ground, which the planner is not told, in index order.
    pub cells: Vec<Ground>,
}

/// How an episode ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Episode {
    /// Goal, deadlock, left map or lost.
    pub status: Status,
    /// Steps in the paper's count.
    pub steps: u64,
}

/// The profiles of P23's world.
pub const PROFILES: [Profile; 2] = [Profile::Paper2023, Profile::Hopper];

/// Scatter, gravity and launch of P23 on Mars.
pub const MOTION: MotionParameters = MotionParameters {
    hard: SoilMotion { intended: 0.9, stuck: 0.0, sideways: 0.05, flights: 1 },
    sand: SoilMotion { intended: 0.7, stuck: 0.1, sideways: 0.1, flights: 2 },
    slope_limit_rad: FRAC_PI_6,
    launch_angle_rad: FRAC_PI_4,
    gravity_mps2: 3.72,
    vertical: false,
    table: 0,
};

/// The map with these treasures seen and not yet collected.
pub fn with_treasures(mut map: ObservedMap, treasures: &[Cell]) -> ObservedMap {
    map.set_treasures(treasures);
    map.mark();
    map
}

impl World {
    /// The 20 × 20 world of P23 with weights (w1, w2), 10 for the distance.
    pub fn paper(soils: Soils, [safety, information]: [f64; 2], profile: Profile) -> Self {
        let grid = Grid::new(20, 20, 1.0, 1).unwrap();
        let cells = grid.iter().map(|cell| paper_ground(soils, cell)).collect();
        let weights = Weights { safety, information, distance: 10.0 };
        Self::new(grid, cells, (Cell::new(1, 2), Cell::new(18, 18)), weights, profile)
    }

    /// A small world drawn from `seed`: rough ground, some of it steeper than a hop can climb, with
    /// sand, impassable cells, and hops of one or two cells.
    pub fn random(seed: u64, profile: Profile) -> Self {
        let draw = |index: u64| {
            let mut draw = Draw::new(seed, Domain::Motion, RobotId(9), Decision(index));
            std::array::from_fn::<f64, 8, _>(|_| draw.uniform())
        };
        let [width, height, stride, sand, impassable, w1, w2, trap] = draw(0);
        let hop_cells = if stride < 0.25 { 2 } else { 1 };
        let side = |uniform: f64| 4 + (uniform * 7.0) as u32 * hop_cells;
        let grid = Grid::new(side(width), side(height), 1.0, hop_cells).unwrap();
        let lattice = |index: u64| {
            let [x, y, ..] = draw(index);
            let along = |uniform: f64, side: u32| (uniform * f64::from(side / hop_cells)) as i32;
            Cell::new(along(x, grid.width) * hop_cells as i32, along(y, grid.height) * hop_cells as i32)
        };
        let (start, goal) = (lattice(1), lattice(2));
        let cells = (0..grid.cells())
            .map(|index| {
                let [h, gx, gy, steep, soil, rock, ..] = draw(3 + index as u64);
                let slope = if steep < 0.1 { 2.0 } else { 0.4 };
                let may_stand = [start, goal].contains(&grid.cell(index));
                Ground {
                    height_m: h - 0.5,
                    gradient: [slope * (2.0 * gx - 1.0), slope * (2.0 * gy - 1.0)],
                    soil: if soil < sand { Soil::Sand } else { Soil::Hard },
                    passable: may_stand || rock > 0.3 * impassable,
                    ..Ground::FLAT
                }
            })
            .collect();
        // A third of the worlds are traps, where lingering on a hill beats the goal.
        let gain = if trap < 1.0 / 3.0 { 100.0 } else { 1.0 };
        let weights = Weights { safety: gain * w1, information: gain * w2, distance: 10.0 };
        Self::new(grid, cells, (start, goal), weights, profile)
    }

    /// A flat hard square of `side` cells, which nobody has to look at.
    pub fn flat(side: u32, start: Cell, goal: Cell, profile: Profile) -> Self {
        let grid = Grid::new(side, side, 1.0, 1).unwrap();
        let weights = Weights { safety: 0.5, information: 0.5, distance: 10.0 };
        Self::new(grid, vec![Ground::FLAT; grid.cells()], (start, goal), weights, profile)
    }

    /// Flat ground with payoffs that differ by a few hundred-thousandths, and a discount far out: hops that lose
    /// about as much as may still count as equal, by values that are hard to solve for.
    pub fn doubtful(seed: u64) -> Self {
        let mut world = Self::flat(9, Cell::new(1, 1), Cell::new(7, 7), PROFILES[seed as usize % 2]);
        world.leg.payoff.discount = [0.9995, 0.9999][seed as usize / 2 % 2];
        (world.leg.weights.safety, world.leg.weights.information) = (0.0, 1.0);
        world.leg.priors.height_m = Range { min: 0.0, max: 1.0 };
        for (index, ground) in (0..).zip(&mut world.cells) {
            ground.height_m = 1e-4 * Draw::new(seed, Domain::Motion, RobotId(7), Decision(index)).uniform();
        }
        world
    }

    /// A world of `cells` with the constants of P23 and ranges taken over the whole map.
    pub fn new(
        grid: Grid,
        cells: Vec<Ground>,
        (start, goal): (Cell, Cell),
        weights: Weights,
        profile: Profile,
    ) -> Self {
        let payoff = Payoff { goal: 100.0, treasure: 10.0, discount: 0.99, sand_term: -5.0 };
        let safety = |ground: &Ground| {
            -ground.steepness() - if ground.soil == Soil::Sand { payoff.sand_term } else { 0.0 }
        };
        let sensor = SensorParameters {
            gain: 2.0,
            offset_m: 1.0,
            radius_min_m: grid.hop_distance_m(),
            radius_max_m: 100.0,
            gradient: GradientSource::Measured,
        };
        let brief = Brief {
            run: RunId(1),
            scenario: Name::NONE,
            scenario_hash: [0; 32],
            profile,
            grid,
            datum_m: 0.0,
            weights,
            payoff,
            priors: Priors {
                safety: range(cells.iter().map(safety)),
                height_m: range(cells.iter().map(|ground| ground.height_m)),
                treasures: 0,
            },
            limits: Limits { steps_max: 150, decision_budget_ns: 600_000_000 },
            guard: contract::Guard::OFF,
            reading: contract::Reading::default(),
            account: Account::Hopper,
            sampling: None,
            robots: Robots::new(&[Robot::hopper(&grid, MOTION, sensor, [start, goal])]).unwrap(),
        };
        Self { brief: brief.clone(), leg: brief.leg(0), cells }
    }

    /// The ground at a cell of the grid.
    pub fn ground(&self, cell: Cell) -> Option<&Ground> {
        self.cells.get(self.leg.grid.index(cell)?)
    }

    /// A map on which nothing has been seen.
    pub fn unseen(&self) -> ObservedMap {
        ObservedMap::unseen(self.leg.run, RobotId(0), self.leg.grid)
    }

    /// A map on which everything has been seen.
    pub fn seen(&self) -> ObservedMap {
        let cells: Vec<_> = self.cells.iter().copied().map(Some).collect();
        ObservedMap::of_cells(self.leg.run, RobotId(0), self.leg.grid, &cells)
    }

    /// A map on which those cells have been seen whose index `is_seen`.
    pub fn seen_where(&self, mut is_seen: impl FnMut(usize) -> bool) -> ObservedMap {
        let cells: Vec<_> = (0..self.cells.len()).map(|i| is_seen(i).then(|| self.cells[i])).collect();
        ObservedMap::of_cells(self.leg.run, RobotId(0), self.leg.grid, &cells)
    }

    /// Folds in what can be seen from `cell`: the closed disc of radius 2(h+1).
    pub fn sense(&self, map: &mut ObservedMap, from: Cell) {
        let Some(ground) = self.ground(from) else { return };
        let reach_cells = self.leg.sensor.reach_cells(&self.leg.grid, ground.height_m);
        let reach = reach_cells.floor() as i32;
        for y in from.y - reach..=from.y + reach {
            for x in from.x - reach..=from.x + reach {
                let cell = Cell::new(x, y);
                if let Some(index) = self.leg.grid.index(cell)
                    && cell.distance_cells(from) <= reach_cells
                {
                    map.learn(index, self.cells[index]);
                }
            }
        }
        map.mark();
    }

    /// The state of a hopper at `cell`.
    pub fn state(&self, cell: Cell, decision: Decision, steps: u64) -> State {
        State {
            run: self.leg.run,
            robot: RobotId(0),
            decision,
            steps,
            status: Status::Underway,
            leader: Leader::default(),
            pose: Pose { cell, height_m: self.ground(cell).map_or(0.0, |ground| ground.height_m) },
            collected: contract::Collected::default(),
            last: None,
            previous: Digest::default(),
            digest: Digest::default(),
            landed: MonotonicNs(0),
            published: MonotonicNs(0),
            visits: 0,
            vetoed: contract::Vetoed::NONE,
            last_origin: contract::Origin::Planner,
            last_vetoed: contract::Vetoed::NONE,
            last_timing: Timing::default(),
        }
    }

    /// What there is to plan for.
    pub fn situation<'a>(&'a self, map: &'a ObservedMap, state: &'a State) -> Situation<'a> {
        Situation::alone(&self.brief, &self.leg, map, state)
    }

    /// What `planner` answers at `cell` on `map`, without a bound on its work.
    pub fn plan(&self, planner: &mut dyn Planner, map: &ObservedMap, cell: Cell) -> Plan {
        self.plan_within(planner, map, cell, &Budget::default())
    }

    /// What `planner` answers at `cell` on `map` within `budget`.
    pub fn plan_within(
        &self,
        planner: &mut dyn Planner,
        map: &ObservedMap,
        cell: Cell,
        budget: &Budget,
    ) -> Plan {
        let state = self.state(cell, Decision(0), 0);
        planner.plan(&self.situation(map, &state), budget)
    }

    /// Where `action` leads from `cell`, and what it costs in steps.
    pub fn hop(&self, cell: Cell, action: Action, seed: u64, decision: Decision) -> (Cell, u64) {
        let ground = self.ground(cell).expect("the hopper stands on the map");
        let (branch, to) = match action {
            Action::Hop(direction) | Action::Up(direction) => {
                let uniform = Draw::new(seed, Domain::Motion, RobotId(0), decision).uniform();
                let height_m = |cell| self.ground(cell).map(|ground| ground.height_m);
                let offers = motion::offers(&self.leg.motion, &self.leg.grid, (cell, ground), height_m);
                let offer = offers[direction as usize].filter(|offer| offer.action == action);
                // What is not offered stays.
                let branch = offer.map_or(Branch::Stayed, |offer| offer.scatter().branch(uniform));
                (branch, landing(&self.leg.grid, cell, direction, branch))
            }
            _ => (Branch::Held, cell),
        };
        (to, steps(ground.soil, action, branch))
    }

    /// One mission from start to end, `watch` seeing every situation.
    pub fn fly(
        &self,
        planner: &mut dyn Planner,
        seed: u64,
        mut watch: impl FnMut(&Situation<'_>, &Plan),
    ) -> Episode {
        let mut map = self.unseen();
        let mut cell = self.leg.start;
        let mut steps = 0;
        for decision in (0..).map(Decision) {
            self.sense(&mut map, cell);
            let state = self.state(cell, decision, steps);
            let situation = self.situation(&map, &state);
            let plan = planner.plan(&situation, &Budget::default());
            watch(&situation, &plan);
            let (to, cost) = self.hop(cell, plan.action, seed, decision);
            steps += cost;
            cell = to;
            let status = match self.ground(cell) {
                None => Status::LeftMap,
                Some(ground) if !ground.passable => Status::Lost,
                Some(_) if cell == self.leg.goal && steps <= self.leg.limits.steps_max => Status::Goal,
                Some(_) if steps >= self.leg.limits.steps_max => Status::Deadlock,
                Some(_) => continue,
            };
            return Episode { status, steps };
        }
        unreachable!("the step limit ends every episode")
    }
}

/// Five elevated and three depressed Gaussians of σ = 2 m, in table order.
const HILLS: [([f64; 2], f64); 8] = [
    ([1.0, 6.0], 1.0),
    ([5.0, 0.0], 1.0),
    ([5.0, 20.0], 1.0),
    ([7.0, 14.0], 1.0),
    ([8.0, 8.0], 1.0),
    ([10.0, 18.0], -1.0),
    ([12.0, 1.0], -1.0),
    ([15.0, 10.0], -1.0),
];

fn paper_ground(soils: Soils, cell: Cell) -> Ground {
    const SIGMA_M: f64 = 2.0;
    let (x, y) = (f64::from(cell.x), f64::from(cell.y));
    let mut ground = Ground::FLAT;
    for ([cx, cy], sign) in HILLS {
        let (dx, dy) = (x - cx, y - cy);
        let h = sign / (2.0 * PI) * libm::exp(-(dx * dx + dy * dy) / (2.0 * SIGMA_M * SIGMA_M));
        ground.height_m += h;
        ground.gradient[0] -= h * dx / (SIGMA_M * SIGMA_M);
        ground.gradient[1] -= h * dy / (SIGMA_M * SIGMA_M);
    }
    let sand = match soils {
        Soils::Hard => false,
        Soils::Heterogeneous => (5..=11).contains(&cell.x) && (3..=11).contains(&cell.y),
        Soils::Sandy => ground.height_m < 0.1,
    };
    ground.soil = if sand { Soil::Sand } else { Soil::Hard };
    ground
}

fn range(values: impl Iterator<Item = f64>) -> Range {
    values.fold(Range { min: f64::INFINITY, max: f64::NEG_INFINITY }, |range, value| Range {
        min: range.min.min(value),
        max: range.max.max(value),
    })
}
