//! A small world, a scripted planner, a host that carries out the arbiter's effects.

use std::ops::Range;
use std::sync::Arc;

use contract::{
    Account, Action, Body, Brief, Cell, Command, Direction, GradientSource, Grid, Ground, Heartbeat,
    Incarnation, Limits, MonotonicNs, MotionParameters, Name, Payoff, Priors, Profile, Record, Robot, Robots,
    Role, RunId, Sensor, SensorParameters, Soil, SoilMotion, State, Status, Term, Weights,
};
use hopper_sim::{Arbiter, Effect, Event, JournalHeader, Mission, Pace, ROBOT};
use terrain::Terrain;

pub const RUN: RunId = RunId(0x0123_4567_89ab_cdef_0011_2233_4455_6677);
pub const LINGER_NS: u64 = 2_000_000_000;
pub const EAST: Action = Action::Hop(Direction::East);
pub const WEST: Action = Action::Hop(Direction::West);

pub fn name(text: &str) -> Name {
    text.parse().unwrap()
}

pub fn brief() -> Brief {
    let soil = |intended, stuck, sideways, flights| SoilMotion { intended, stuck, sideways, flights };
    let grid = Grid::new(9, 9, 1.0, 1).unwrap();
    let motion = MotionParameters {
        hard: soil(0.9, 0.0, 0.05, 1),
        sand: soil(0.7, 0.1, 0.1, 2),
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
        radius_max_m: 8.0,
        gradient: GradientSource::Measured,
    };
    let hopper = Robot::hopper(&grid, motion, sensor, [Cell::new(1, 2), Cell::new(7, 6)]);
    Brief {
        run: RUN,
        scenario: name("bench"),
        scenario_hash: [7; 32],
        profile: Profile::Hopper,
        grid,
        datum_m: -4139.0,
        weights: Weights { safety: 0.5, information: 0.5, distance: 10.0 },
        payoff: Payoff { goal: 100.0, treasure: 10.0, discount: 0.99, sand_term: -5.0 },
        priors: Priors {
            safety: contract::Range { min: -0.1, max: 5.0 },
            height_m: contract::Range { min: -0.2, max: 0.2 },
            treasures: 0,
        },
        limits: Limits { steps_max: 150, decision_budget_ns: 600_000_000 },
        guard: contract::Guard::OFF,
        reading: contract::Reading::default(),
        account: Account::Hopper,
        sampling: None,
        robots: Robots::new(&[hopper]).unwrap(),
    }
}

/// How the hopper hops.
pub fn law(brief: &mut Brief) -> &mut MotionParameters {
    let Body::Hopper(hopper) = &mut brief.robots[0].body else { unreachable!("robot 0 is a hopper") };
    &mut hopper.motion
}

/// How far the hopper sees.
pub fn disc(brief: &mut Brief) -> &mut SensorParameters {
    let Sensor::Disc(disc) = &mut brief.robots[0].sensor else { unreachable!("robot 0 is a hopper") };
    disc
}

/// A ramp to the north-east with sand in its middle and one rock.
pub fn mission() -> Mission {
    let brief = brief();
    let ground = |cell: Cell| Ground {
        height_m: 0.01 * f64::from(cell.x) + 0.02 * f64::from(cell.y),
        gradient: [0.01, 0.02],
        soil: if (3..=5).contains(&cell.x) { Soil::Sand } else { Soil::Hard },
        passable: cell != Cell::new(8, 0),
        ..Ground::FLAT
    };
    let cells = brief.grid.iter().map(ground).collect();
    let terrain = Terrain { grid: brief.grid, cells, treasures: Vec::new(), prior: Vec::new() };
    Mission::under_law(brief, terrain, 42)
}

/// The mission with hops that always land where they are meant to, from `start`.
pub fn sure_mission(start: Cell) -> Mission {
    let mut mission = mission();
    mission.brief.robots[0].start.cell = start;
    let MotionParameters { hard, sand, .. } = law(&mut mission.brief);
    for soil in [hard, sand] {
        *soil = SoilMotion { intended: 1.0, stuck: 0.0, sideways: 0.0, ..*soil };
    }
    for ground in &mut Arc::make_mut(&mut mission.terrain).cells {
        ground.gradient = [0.0; 2];
    }
    mission
}

/// The header of the mission on a ground that no scenario has: its file is nowhere.
pub fn header(mission: &Mission) -> JournalHeader {
    let resolved = "[truth.terrain.elevation_file]\nfile = \"/nowhere/ramp.tif\"\n\
                    [brief]\nname = \"bench\"\nprofile = \"hopper\"\nstart = [1, 2]\ngoal = [7, 6]\n"
        .into();
    JournalHeader { resolved, ..JournalHeader::untold(mission) }
}

/// A frame of a journal.
pub fn frame(payload: &[u8]) -> Vec<u8> {
    let length = (payload.len() as u32).to_le_bytes();
    let checksum = crc32fast::hash(&[&length, payload].concat()).to_le_bytes();
    [&length, &checksum, payload].concat()
}

/// Where the payloads of the header lie that `bytes` begin with: the version of the build, and the text. Magic and format stand
/// before them, length and checksum before each.
pub fn header_payloads(bytes: &[u8]) -> [Range<usize>; 2] {
    let payload = |at: usize| {
        let length = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        at + 8..at + 8 + length as usize
    };
    let version = payload(12);
    let text = payload(version.end);
    [version, text]
}

/// Towards the goal along the longer side, with a halt every seventh decision.
pub fn steer(brief: &Brief, state: &State) -> Action {
    let goal = brief.goal_after(state.visits).unwrap();
    let (dx, dy) = (goal.x - state.pose.cell.x, goal.y - state.pose.cell.y);
    let direction = match (dx.abs() >= dy.abs(), dx > 0, dy > 0) {
        (true, true, _) => Direction::East,
        (true, false, _) => Direction::West,
        (false, _, true) => Direction::North,
        (false, _, false) => Direction::South,
    };
    if state.decision.0 % 7 == 6 { Action::Hold } else { Action::Hop(direction) }
}

/// A command that the planner of life 1 would give at `state`, in its first term.
pub fn command(state: &State, action: Action) -> Command {
    Command {
        run: state.run,
        robot: ROBOT,
        decision: state.decision,
        digest: state.digest,
        term: Term(1),
        action,
        observation: 5,
        planner: name("mdp"),
        incarnation: Incarnation(1),
        pid: 100,
        work: 12,
        cut: false,
        sensed: state.published.plus_ns(10),
        map_published: state.published.plus_ns(20),
        planning_started: state.published.plus_ns(30),
        planning_ended: state.published.plus_ns(40),
    }
}

pub fn beat(role: Role, life: u64, counter: u64, status: Status) -> Heartbeat {
    Heartbeat {
        role,
        incarnation: Incarnation(life),
        pid: life as u32,
        version: name("0.1.0"),
        planner: Name::NONE,
        counter,
        run: RUN,
        decision: contract::Decision(0),
        status,
        robots: contract::RobotSet::default(),
    }
}

/// Carries out effects in virtual time: appends into a vector, publishes into another.
pub struct Host {
    pub arbiter: Arbiter,
    pub now: MonotonicNs,
    pub records: Vec<Record>,
    pub published: Vec<State>,
    pub announced: u32,
    pub finished: Vec<Status>,
    pub refused: Vec<&'static str>,
}

impl Host {
    /// A host at time 1,000 whose first tick has been.
    pub fn new(mission: Mission, records: Vec<Record>, pace: Pace) -> Self {
        let now = MonotonicNs(1_000);
        let arbiter = Arbiter::new(mission, records.last(), pace, LINGER_NS, now);
        let mut host = Self {
            arbiter,
            now,
            records,
            published: Vec::new(),
            announced: 0,
            finished: Vec::new(),
            refused: Vec::new(),
        };
        host.on(Event::Tick);
        host
    }

    pub fn fresh() -> Self {
        Self::new(mission(), Vec::new(), Pace::Max)
    }

    pub fn state(&self) -> State {
        *self.arbiter.state()
    }

    /// Feeds one event; appends succeed 5 ns later.
    pub fn on(&mut self, event: Event) {
        for effect in self.arbiter.on(event, self.now) {
            match effect {
                Effect::Append(record) => {
                    self.records.push(record);
                    self.now = self.now.plus_ns(5);
                    self.on(Event::Appended);
                }
                Effect::Announce => self.announced += 1,
                Effect::Publish(state) => self.published.push(state),
                Effect::Refused(refusal) => self.refused.push(refusal.reason()),
                Effect::Finished(status) => self.finished.push(status),
            }
        }
    }

    pub fn send(&mut self, command: Command) {
        self.on(Event::Command(Ok(command)));
    }

    pub fn tick_after(&mut self, ns: u64) {
        self.now = self.now.plus_ns(ns);
        self.on(Event::Tick);
    }

    /// Flies to the end under one planner.
    pub fn fly(&mut self) -> &mut Self {
        while !self.state().status.is_over() {
            let state = self.state();
            self.now = self.now.plus_ns(100);
            self.send(command(&state, steer(&self.arbiter.mission().brief, &state)));
            assert!(self.state().decision > state.decision, "the mission moves on: {:?}", self.refused);
        }
        self
    }
}

/// Every record of the undisturbed mission.
pub fn undisturbed() -> Vec<Record> {
    let records = std::mem::take(&mut Host::fresh().fly().records);
    assert!(records.len() > 10, "the mission is long enough to prove something");
    records
}
