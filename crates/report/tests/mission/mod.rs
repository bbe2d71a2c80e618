//! A small mission to report on.

use contract::{
    Account, Action, Body, Branch, Brief, Camera, Cell, Decision, Digest, Direction, Driver, Goal,
    GradientSource, Grid, Ground, Helicopter, Incarnation, Leader, Limits, LookAhead, MonotonicNs,
    MotionParameters, Name, ObservedMap, Outcome, Payoff, PolicyCell, Pose, Priors, Profile, Range, Reach,
    Record, Robot, RobotId, Robots, RunId, Sampling, Sensor, SensorParameters, Soil, SoilMotion, Status,
    Term, Timing, Track, Waypoint, Weights,
};

pub fn name(text: &str) -> Name {
    text.parse().unwrap()
}

/// A square world of `side` cells of one metre, from (1, 1) to the cell before the last.
pub fn brief(side: u32) -> Brief {
    let soil = SoilMotion { intended: 0.9, stuck: 0.0, sideways: 0.05, flights: 1 };
    let range = Range { min: -1.0, max: 1.0 };
    let grid = Grid::new(side, side, 1.0, 1).unwrap();
    let motion = MotionParameters {
        hard: soil,
        sand: soil,
        slope_limit_rad: 0.5,
        launch_angle_rad: 0.785,
        gravity_mps2: 3.72,
        vertical: false,
        table: 0,
    };
    let sensor = SensorParameters {
        gain: 2.0,
        offset_m: 1.0,
        radius_min_m: 1.0,
        radius_max_m: 9.0,
        gradient: GradientSource::Measured,
    };
    let ends = [Cell::new(1, 1), Cell::new(side as i32 - 2, side as i32 - 2)];
    Brief {
        run: RunId(1),
        scenario: name("tiny"),
        scenario_hash: [7; 32],
        profile: Profile::Paper2023,
        grid,
        datum_m: 0.0,
        weights: Weights { safety: 0.5, information: 0.5, distance: 10.0 },
        payoff: Payoff { goal: 100.0, treasure: 10.0, discount: 0.99, sand_term: -5.0 },
        priors: Priors { safety: range, height_m: range, treasures: 0 },
        limits: Limits { steps_max: 150, decision_budget_ns: 600_000_000 },
        guard: contract::Guard::OFF,
        reading: contract::Reading::default(),
        account: Account::Hopper,
        sampling: None,
        robots: Robots::new(&[Robot::hopper(&grid, motion, sensor, ends)]).unwrap(),
    }
}

/// Where robot 0 of `brief` starts.
pub fn start(brief: &Brief) -> Cell {
    brief.robots[0].start.cell
}

/// The goal of robot 0 of `brief`, if it has one.
fn goal(brief: &Brief) -> Option<Cell> {
    brief.robots[0].goal.cell(&brief.grid, 0)
}

/// The mission of `brief` with other robots.
#[allow(dead_code)]
pub fn with_robots(brief: &Brief, account: Account, robots: &[Robot]) -> Brief {
    let sampling = Sampling { seed: 1, rover_samples: 10, helicopter_samples: 10, stages: 1 };
    let drives = robots.iter().any(|robot| robot.body.drives());
    let sampling = if drives { Some(sampling) } else { None };
    Brief { account, sampling, robots: Robots::new(robots).unwrap(), ..*brief }
}

/// A rover that drives from where the hopper of `brief` starts.
#[allow(dead_code)]
pub fn driver(brief: &Brief, to: Waypoint) -> Robot {
    let goal = Goal::Reach(Reach { at: to, radius_m: 3.0 });
    Robot { body: Body::Driver(Driver {}), sensor: Sensor::Track(Track {}), goal, ..brief.robots[0] }
}

/// A helicopter that flies from where the hopper of `brief` starts, and sees 3 m to each side.
#[allow(dead_code)]
pub fn helicopter(brief: &Brief) -> Robot {
    Robot {
        body: Body::Helicopter(Helicopter { speed_mps: 5.0, budget_m: 300.0 }),
        sensor: Sensor::Camera(Camera { radius_m: 3.0 }),
        goal: Goal::LookAhead(LookAhead {}),
        required: false,
        ..brief.robots[0]
    }
}

/// One command and what became of it.
pub type Step = (Action, Branch);

/// The records of `steps`, commanded by mdp in term 1, from decision `swap` on by greedy in term 2.
pub fn records(brief: &Brief, steps: &[Step], swap: u64) -> Vec<Record> {
    let (mut cell, goal) = (start(brief), goal(brief));
    let mut records: Vec<Record> = Vec::new();
    for (n, &(action, branch)) in (0..).zip(steps) {
        let from = cell;
        cell = match (action, branch) {
            (Action::Hop(direction), Branch::Intended) => brief.grid.hop(from, direction),
            (Action::Hop(direction), Branch::Left) => brief.grid.hop(from, direction.left()),
            (Action::Hop(direction), Branch::Right) => brief.grid.hop(from, direction.right()),
            _ => from,
        };
        let (planner, term) = if n < swap { ("mdp", 1) } else { ("greedy", 2) };
        let landed = 1_000_000_000 * (n + 1);
        let previous = records.last().map_or(Digest::default(), |record| record.digest);
        let steps = records.last().map_or(0, |record| record.steps);
        let status = match brief.grid.contains(cell) {
            false => Status::LeftMap,
            true if Some(cell) == goal => Status::Goal,
            true => Status::Underway,
        };
        let mut record = Record {
            robot: RobotId(0),
            decision: Decision(n),
            leader: Leader {
                term: Term(term),
                incarnation: Incarnation(term),
                pid: 40,
                planner: name(planner),
            },
            action,
            origin: contract::Origin::Planner,
            visits: 0,
            vetoed: contract::Vetoed::NONE,
            observation: 0,
            work: 10,
            cut: false,
            outcome: Outcome { branch, from, to: cell, flight: contract::Flight::default() },
            pose: Pose { cell, height_m: 0.1 * f64::from(cell.x) },
            detail: contract::DetailId::NONE,
            collected: contract::Collected::default(),
            steps: steps + if action == Action::Hold { 1 } else { 2 },
            status,
            timing: Timing::from_moments(
                [0, 1_000, 21_000, 26_000, 30_000, 230_000, 240_000, 300_000]
                    .map(|ns| MonotonicNs(landed + ns)),
            ),
            previous,
            digest: Digest::default(),
        };
        record.digest = previous.chain(&record);
        records.push(record);
    }
    records
}

/// Rolling ground with a patch of sand and a wall, of which what lies below the diagonal is seen.
#[allow(dead_code)]
pub fn ground(brief: &Brief) -> (Vec<Ground>, ObservedMap) {
    let side = f64::from(brief.grid.width);
    let terrain: Vec<Ground> = brief
        .grid
        .iter()
        .map(|cell| {
            let (x, y) = (f64::from(cell.x) / side, f64::from(cell.y) / side);
            Ground {
                height_m: 0.4 * (9.0 * x).sin() * (7.0 * y).cos() + 0.05 * (97.0 * x * y).sin(),
                soil: if (0.4..0.6).contains(&x) && y < 0.5 { Soil::Sand } else { Soil::Hard },
                passable: !(0.7..0.8).contains(&x) || y > 0.3,
                ..Ground::FLAT
            }
        })
        .collect();
    let mut map = ObservedMap::unseen(brief.run, RobotId(0), brief.grid);
    for (index, cell) in brief.grid.iter().enumerate() {
        if cell.y <= cell.x + 1 {
            map.learn(index, terrain[index]);
        }
    }
    (terrain, map)
}

/// A policy that heads for the goal's column, then its row.
#[allow(dead_code)]
pub fn policy(brief: &Brief) -> Vec<PolicyCell> {
    let goal = goal(brief).unwrap();
    let towards = |cell: Cell| match (goal.x - cell.x, goal.y - cell.y) {
        (0, 0) => Action::Hold,
        (0, dy) => Action::Hop(if dy > 0 { Direction::North } else { Direction::South }),
        (dx, _) => Action::Hop(if dx > 0 { Direction::East } else { Direction::West }),
    };
    brief.grid.iter().map(|cell| PolicyCell { action: towards(cell), value: 0.0 }).collect()
}
