//! Valid input, small: what hostile input is made of.

use std::sync::LazyLock;

use contract::{
    Action, Brief, Cell, Command, Decision, Direction, Heartbeat, Incarnation, MonotonicNs, Name, Record,
    RobotSet, Role, RunId, State, Status, Term,
};
use hopper_sim::{Arbiter, Effect, Event, Mission, Pace, ROBOT};
use scenario::{ResolvedScenario, Scenario};

/// A scenario with every field of generated hills at given places.
pub const GAUSSIANS: &str = r#"
[truth]
treasures = [[2, 4], [5, 1]]
[truth.terrain.gaussians]
width_cells = 7
height_cells = 6
cell_size_m = 0.5
sigma_m = 0.8
amplitude_m = 0.1
raised_m = [[1.0, 2.0], [2.5, 0.0]]
lowered_m = [[3.0, 3.0]]
[truth.sand]
rectangles = [{ x = [3, 4], y = [0, 5] }]
below_height_m = -0.05
[brief]
name = "specimen"
profile = "hopper"
start = [0, 0]
goal = [6, 5]
datum_m = 0.0
weights = { safety = 0.5, information = 0.5, distance = 10.0 }
payoff = { goal = 100.0, treasure = 20.0, discount = 0.99, sand_term = -5.0 }
priors = { safety = [-1.0, 5.0], height_m = "survey" }
[robot]
hop_distance_m = 0.5
launch_angle_deg = 45.0
gravity_mps2 = 3.72
slope_limit_deg = 30.0
hard = { intended = 0.9, stuck = 0.0, sideways = 0.05, flights = 1 }
sand = { intended = 0.7, stuck = 0.1, sideways = 0.1, flights = 2 }
[robot.sensor]
gain = 1.0
offset_m = 1.0
radius_min_m = 0.5
radius_max_m = 2.0
gradient = "seen_differences"
[limits]
steps_max = 60
decision_budget_ms = 600
"#;

/// A scenario of random hills with hops of two cells.
pub const RANDOM_HILLS: &str = r#"
[truth.terrain.random_hills]
width_cells = 9
height_cells = 11
cell_size_m = 1.0
seed = 7
hills = 5
sigma_m = [0.5, 2.0]
amplitude_m = [0.05, 0.2]
reach_sigma = 6.0
[brief]
start = [0, 0]
goal = [8, 10]
datum_m = "survey"
[robot]
hop_distance_m = 2.0
"#;

/// A scenario of two rovers, one of which fails.
pub const ROVERS: &str = r#"
[truth.terrain.obstacles]
width_cells = 7
height_cells = 6
cell_size_m = 0.5
percent = 10.0
seed = 3
[brief]
name = "rovers"
[[robots]]
body = "rover"
start = [0, 0]
speed_mps = 0.2
planner = "spiral"
goal = { cover = 90, mode = "voronoi" }
[[robots]]
body = "rover"
start = [6, 5]
heading = "west"
sensor_range_cells = 2
speed_mps = 0.5
goal = { cover = 90, mode = "voronoi" }
[[faults]]
robot = 1
action = 4
"#;

/// The run of the missions here.
pub const RUN: RunId = RunId(0x0123_4567_89ab_cdef_0011_2233_4455_6677);

/// The life of the planner in command here.
pub const LIFE: Incarnation = Incarnation(0x1eaf);

static WORLD: LazyLock<ResolvedScenario> = LazyLock::new(|| {
    let scenario = Scenario::parse(GAUSSIANS, "specimen").and_then(|scenario| scenario.resolve());
    scenario.expect("the fixture is a scenario")
});

/// The world of [`GAUSSIANS`].
#[must_use]
pub fn world() -> &'static ResolvedScenario {
    &WORLD
}

/// The brief of [`mission`].
#[must_use]
pub fn brief() -> Brief {
    Brief { run: RUN, ..world().brief.clone() }
}

/// A mission in [`world`].
#[must_use]
pub fn mission() -> Mission {
    Mission::under_law(brief(), world().terrain.clone(), 42)
}

/// The command of the planner in command at `state`: towards the goal.
#[must_use]
pub fn command(state: &State) -> Command {
    let Cell { x, y } = brief().leg(0).goal;
    let (dx, dy) = (x.saturating_sub(state.pose.cell.x), y.saturating_sub(state.pose.cell.y));
    let direction = match (dx.saturating_abs() >= dy.saturating_abs(), dx > 0, dy > 0) {
        (true, true, _) => Direction::East,
        (true, false, _) => Direction::West,
        (false, _, true) => Direction::North,
        (false, _, false) => Direction::South,
    };
    let moment = |ns: u64| MonotonicNs(1_000 + ns);
    Command {
        run: RUN,
        robot: ROBOT,
        decision: state.decision,
        digest: state.digest,
        term: Term(1),
        action: Action::Hop(direction),
        observation: 5,
        planner: name("greedy"),
        incarnation: LIFE,
        pid: 100,
        work: 12,
        cut: false,
        sensed: moment(10),
        map_published: moment(20),
        planning_started: moment(30),
        planning_ended: moment(40),
    }
}

/// A beat of the planner in command.
#[must_use]
pub fn heartbeat() -> Heartbeat {
    Heartbeat {
        role: Role::Planner,
        incarnation: LIFE,
        pid: 100,
        version: name("0.1.0"),
        planner: name("greedy"),
        counter: 3,
        run: RUN,
        decision: Decision(1),
        status: Status::Underway,
        robots: RobotSet::default(),
    }
}

/// The records of [`mission`] and the state after each, the opening one first.
#[must_use]
pub fn flown() -> (Vec<Record>, Vec<State>) {
    let mut now = MonotonicNs(1_000);
    let mut arbiter = Arbiter::new(mission(), None, Pace::Max, 0, now);
    let (mut records, mut states) = (Vec::new(), Vec::new());
    let mut events = vec![Event::Tick];
    while let Some(event) = events.pop() {
        now = now.plus_ns(100);
        for effect in arbiter.on(event, now) {
            match effect {
                Effect::Append(record) => {
                    records.push(record);
                    events.push(Event::Appended);
                }
                Effect::Publish(state) => {
                    states.push(state);
                    if !state.status.is_over() {
                        events.push(Event::Command(Ok(command(&state))));
                    }
                }
                _ => {}
            }
        }
    }
    (records, states)
}

fn name(text: &str) -> Name {
    text.parse().expect("a name")
}
