//! Messages and instances for tests.

use std::time::{Duration, Instant};

use contract::{
    Account, Action, Branch, Brief, Cell, Command, Decision, Digest, Direction, Flight, GradientSource, Grid,
    Ground, Incarnation, Leader, Limits, MapPage, MapPatch, MapRequest, MonotonicNs, MotionParameters, Name,
    Outcome, Payoff, Policy, PolicyCell, Pose, Priors, Profile, Range, Record, Robot, RobotId, Robots, RunId,
    SeenCell, SensorParameters, SoilMotion, State, Status, Term, Timing, TruthPage, TruthRequest, Weights,
};
use node::{Instance, SHARED_MEMORY};

pub const RUN: RunId = RunId(0x1234_5678_9abc_def0);
pub const ROBOT: RobotId = RobotId(0);

/// An instance of a test's own, of which nothing may be left at the end.
pub struct Own(pub Instance);

impl Own {
    pub fn new() -> Self {
        let nonce = node::random_run().unwrap();
        Self(Instance::new(&format!("test-{nonce}")).unwrap())
    }

    /// What is in shared memory of this instance.
    pub fn files(&self) -> Vec<String> {
        let tag = self.0.root().file_name().unwrap().to_str().unwrap().to_owned();
        std::fs::read_dir(SHARED_MEMORY)
            .unwrap()
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name.starts_with(&tag))
            .collect()
    }

    pub fn assert_gone(&self) {
        assert_eq!(self.files(), Vec::<String>::new(), "of instance {}", self.0.name());
    }
}

/// Waits until `probe` gives something.
pub fn eventually<T>(what: &str, mut probe: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = probe() {
            return found;
        }
        assert!(started.elapsed() < Duration::from_secs(10), "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

pub fn grid() -> Grid {
    Grid::new(5, 4, 1.0, 1).unwrap()
}

pub fn name(text: &str) -> Name {
    text.parse().unwrap()
}

pub fn ground(height_m: f64) -> Ground {
    Ground { height_m, ..Ground::FLAT }
}

pub fn brief() -> Brief {
    let soil =
        |stuck, sideways| SoilMotion { intended: 1.0 - stuck - 2.0 * sideways, stuck, sideways, flights: 1 };
    let motion = MotionParameters {
        hard: soil(0.1, 0.05),
        sand: soil(0.2, 0.1),
        slope_limit_rad: 0.5,
        launch_angle_rad: 0.78,
        gravity_mps2: 3.71,
        vertical: false,
        table: 0,
    };
    let sensor = SensorParameters {
        gain: 2.0,
        offset_m: 1.0,
        radius_min_m: 1.0,
        radius_max_m: 10.0,
        gradient: GradientSource::Measured,
    };
    let hopper = Robot::hopper(&grid(), motion, sensor, [Cell::new(0, 0), Cell::new(4, 3)]);
    Brief {
        run: RUN,
        scenario: name("test"),
        scenario_hash: [7; 32],
        profile: Profile::Hopper,
        grid: grid(),
        datum_m: -4000.0,
        weights: Weights { safety: 1.0, information: 1.0, distance: 1.0 },
        payoff: Payoff { goal: 10.0, treasure: 5.0, discount: 0.9, sand_term: 0.5 },
        priors: Priors {
            safety: Range { min: -2.0, max: 0.0 },
            height_m: Range { min: 0.0, max: 3.0 },
            treasures: 0,
        },
        limits: Limits { steps_max: 100, decision_budget_ns: 600_000_000 },
        guard: contract::Guard::OFF,
        reading: contract::Reading::default(),
        account: Account::Hopper,
        sampling: None,
        robots: Robots::new(&[hopper]).unwrap(),
    }
}

pub fn outcome() -> Outcome {
    Outcome {
        branch: Branch::Intended,
        from: Cell::new(0, 0),
        to: Cell::new(1, 0),
        flight: Flight { flights: 1, ..Flight::default() },
    }
}

pub fn state(decision: u64) -> State {
    State {
        run: RUN,
        robot: ROBOT,
        decision: Decision(decision),
        steps: decision * 2,
        status: Status::Underway,
        leader: Leader::default(),
        pose: Pose { cell: Cell::new(1, 0), height_m: 0.5 },
        collected: contract::Collected::default(),
        last: (decision > 0).then(outcome),
        previous: Digest([2; 32]),
        digest: Digest([3; 32]),
        landed: MonotonicNs(5),
        published: MonotonicNs(6),
        visits: 0,
        vetoed: contract::Vetoed::NONE,
        last_origin: contract::Origin::Planner,
        last_vetoed: contract::Vetoed::NONE,
        last_timing: Timing::default(),
    }
}

pub fn command(decision: u64) -> Command {
    Command {
        run: RUN,
        robot: ROBOT,
        decision: Decision(decision),
        digest: Digest([3; 32]),
        term: Term(1),
        action: Action::Hop(Direction::East),
        observation: 42,
        planner: name("mdp"),
        incarnation: Incarnation(9),
        pid: 1,
        work: 17,
        cut: false,
        sensed: MonotonicNs(1),
        map_published: MonotonicNs(2),
        planning_started: MonotonicNs(3),
        planning_ended: MonotonicNs(4),
    }
}

pub fn patch(sequence: u64) -> MapPatch {
    MapPatch {
        run: RUN,
        robot: ROBOT,
        through: Decision(sequence),
        digest: Digest([3; 32]),
        more: 0,
        sequence,
        before: 1,
        after: 2,
        sensed: MonotonicNs(3),
        published: MonotonicNs(4),
        grid: grid(),
        seen_cells: 9,
        treasures: vec![Cell::new(3, 0)],
        cells: seen_cells(3..9),
    }
}

fn seen_cells(indices: std::ops::Range<u32>) -> Vec<SeenCell> {
    indices.map(|index| SeenCell { index, visits: 0, ground: ground(f64::from(index)) }).collect()
}

pub fn map_page(request: &MapRequest) -> MapPage {
    MapPage {
        run: request.run,
        robot: request.robot,
        through: Decision(8),
        digest: Digest([3; 32]),
        sequence: 9,
        observation: 7,
        sensed: MonotonicNs(3),
        published: MonotonicNs(4),
        grid: grid(),
        from: request.from,
        next: 20,
        treasures: vec![Cell::new(3, 0)],
        cells: seen_cells(request.from..20),
    }
}

pub fn truth_page(request: &TruthRequest) -> TruthPage {
    let grid = grid();
    let cells = (request.from..grid.cells() as u32).map(|index| ground(f64::from(index))).collect();
    TruthPage { run: request.run, grid, from: request.from, cells, treasures: vec![Cell::new(1, 0)] }
}

pub fn policy() -> Policy {
    let cell = PolicyCell { action: Action::Hop(Direction::North), value: 1.25 };
    Policy {
        run: RUN,
        robot: ROBOT,
        decision: Decision(3),
        planner: name("mdp"),
        error_bound: 1e-6,
        cells: vec![cell; grid().cells()],
    }
}

pub fn record(decision: u64) -> Record {
    Record {
        robot: ROBOT,
        decision: Decision(decision),
        leader: Leader { term: Term(1), incarnation: Incarnation(9), pid: 1, planner: name("mdp") },
        action: Action::Hop(Direction::East),
        origin: contract::Origin::Planner,
        visits: 0,
        vetoed: contract::Vetoed::NONE,
        observation: 42,
        work: 17,
        cut: false,
        outcome: outcome(),
        pose: Pose { cell: Cell::new(1, 0), height_m: 0.5 },
        detail: contract::DetailId::NONE,
        collected: contract::Collected::default(),
        steps: 2,
        status: Status::Underway,
        timing: Timing::default(),
        previous: Digest([1; 32]),
        digest: Digest([2; 32]),
    }
}
