//! What is simulated before anything goes wrong: a small world, and who flies in it.

use std::sync::LazyLock;

use contract::limits::TREASURES_MAX;
use contract::{
    Account, Body, Brief, Cell, Cover, CoverMode, Direction, Goal, GradientSource, Grid, Ground, Guard,
    Limits, MotionParameters, Name, Placement, Profile, Robot, RobotId, RobotSet, Robots, Rover, RunId,
    Sensor, SensorParameters, Soil, Square, Visit, Waypoint,
};
use hopper_sim::{Mission, Pace};
use scenario::{CollisionRules, ContactRules, Dynamics, Fault};
use serde::Serialize;
use terrain::Terrain;

use crate::chance::Chance;

mod accompanied;
pub(crate) mod long;
mod mixed;
mod protocol;
mod scouts;

/// What every small world has in common with the paper's hard ground.
static BRIEF: LazyLock<Brief> = LazyLock::new(|| {
    let world = scenario::load("hard").and_then(|scenario| scenario.resolve());
    world.expect("the built-in scenarios are sound").brief
});

/// Whose missions are simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Missions {
    /// A hopper alone.
    #[default]
    Hopper,
    /// One to three rovers that cover ground.
    Rovers,
    /// A rover that drives to a goal over ground of uncertain speed, and one or two helicopters
    /// that look ahead.
    Scouts,
    /// A hopper, and one or two helicopters that look ahead for it.
    Accompanied,
    /// Two to five robots of any kind, each with a goal of its own.
    Mixed,
    /// A hopper on flat ground whose hops land where they are meant to: only the protocol can go wrong.
    Protocol,
}

/// A planner process: its algorithm, and the robots that it commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Seat {
    /// Algorithm of this planner process.
    pub planner: Name,
    /// Robots that this process plans for.
    pub robots: RobotSet,
}

/// Everything about a simulation that is no fault.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Which missions are flown.
    pub missions: Missions,
    /// The mission that is begun first.
    pub mission: Mission,
    /// The planners that are there from the start: every robot has one.
    pub planners: Vec<Seat>,
    /// Another one that stands by, if there is one.
    pub stand_by: Option<Seat>,
    /// Pace of hopper-sim.
    pub pace: Pace,
    /// Whether hopper-sim obeys orders.
    pub control: bool,
    /// Whether the monitor has a screen, from which somebody gives orders and looks at policies.
    pub screen: bool,
    /// Whether the monitor records.
    pub records: bool,
    /// Whether each append reaches the disk before it counts.
    pub sync: bool,
    /// Records in a page of the past: small ones make many pages of a short mission.
    pub page_records: usize,
    /// Cells in a page of the map: small ones make many pages, between which the map grows.
    pub page_cells: usize,
    /// Whether peers stay for the next mission.
    pub stay: bool,
    /// Reads on CLOCK_MONOTONIC when it begins, nanoseconds.
    pub uptime_ns: u64,
    /// Cells in a patch of the map: small ones make many parts of a landing.
    pub patch_cells: usize,
    /// Plans of each life of a planner that take long, and how long, nanoseconds.
    pub slow: (u64, u64),
}

impl Setup {
    /// The setup of a seed.
    ///
    /// # Panics
    /// Never, unless the built-in scenarios are damaged.
    #[must_use]
    pub fn of(missions: Missions, seed: u64) -> Self {
        let mut chance = Chance::new(seed, "setup");
        let mut watch = Chance::new(seed, "watch");
        let screen = watch.one_in(3);
        let setup = Self {
            missions,
            mission: missions.mission(seed, 0),
            planners: missions.planners(seed, &mut chance),
            stand_by: chance.one_in(3).then(|| missions.seat(seed, &mut chance)),
            pace: if chance.one_in(4) || screen && watch.one_in(2) {
                missions.pace(&mut chance)
            } else {
                Pace::Max
            },
            control: watch.one_in(2),
            screen,
            records: watch.one_in(4),
            sync: chance.one_in(2),
            page_records: chance.pick(&[1, 2, 5, contract::limits::PAST_PAGE_RECORDS]),
            page_cells: watch.pick(&[2, 4, 8, 16, 512]) * missions.page_factor(),
            stay: chance.one_in(2),
            uptime_ns: chance.between(2_000_000_000, 90_000_000_000),
            patch_cells: chance.pick(&[1, 3, 8, contract::limits::MAP_PATCH_CELLS]),
            slow: (0, 0),
        };
        if long::is_long(seed) { long::setup(setup) } else { setup }
    }
}

/// The version of this build, as heartbeats carry it.
#[must_use]
pub fn version() -> Name {
    "1".parse().expect("a name")
}

/// The version of another build.
pub(crate) fn foreign_version() -> Name {
    "0".parse().expect("a name")
}

impl Missions {
    /// The `number`th mission of a seed: a run, a world and draws of its own.
    #[must_use]
    pub fn mission(self, seed: u64, number: u64) -> Mission {
        let mut mission = match self {
            Missions::Hopper => hopper_mission(seed, number, Vertical::of(seed, number)),
            Missions::Rovers => rover_mission(seed, number),
            Missions::Scouts => scouts::mission(seed, number),
            Missions::Accompanied => accompanied::mission(seed, number),
            Missions::Mixed => mixed::mission(seed, number),
            Missions::Protocol => protocol::mission(seed, number),
        };
        // The mission that follows another one is short.
        if long::is_long(seed) && number == 0 {
            long::lengthen(self, seed, number, &mut mission);
        }
        mission
    }

    /// An algorithm, the quick ones more often.
    pub(crate) fn algorithm(self, chance: &mut Chance) -> Name {
        let name = match self {
            Missions::Hopper | Missions::Protocol => chance.pick(&HOPPER_PLANNERS),
            Missions::Rovers => chance.pick(planner::COVER_ALGORITHMS),
            Missions::Scouts => {
                let of_rover = chance.one_in(2);
                chance.pick(if of_rover { planner::DRIVE_ALGORITHMS } else { planner::FLY_ALGORITHMS })
            }
            Missions::Accompanied if chance.one_in(2) => planner::AHEAD_ALGORITHMS[0],
            Missions::Accompanied => chance.pick(&HOPPER_PLANNERS),
            Missions::Mixed => {
                let whose = [Missions::Hopper, Missions::Rovers, Missions::Scouts, Missions::Accompanied];
                return chance.pick(&whose).algorithm(chance);
            }
        };
        name.parse().expect("the names of algorithms are names")
    }

    /// How many robots the missions of a seed have.
    pub(crate) fn robots(self, seed: u64) -> u16 {
        match self {
            Missions::Hopper | Missions::Protocol => 1,
            Missions::Mixed => mixed::robots(seed),
            Missions::Rovers if Chance::new(seed, "alone").one_in(8) => 1,
            Missions::Rovers | Missions::Scouts | Missions::Accompanied => {
                Chance::new(seed, "robots").between(2, 3) as u16
            }
        }
    }

    /// How many times larger pages of the map are, which many small ones of a larger map would keep from coming whole.
    fn page_factor(self) -> usize {
        if [Missions::Scouts, Missions::Mixed].contains(&self) { 8 } else { 1 }
    }

    /// A pace that is not the fastest.
    fn pace(self, chance: &mut Chance) -> Pace {
        // A drive of 10 m takes one to five hours.
        if [Missions::Scouts, Missions::Mixed].contains(&self) && chance.one_in(2) {
            return Pace::Times(chance.pick(&[100_000.0, 1_000_000.0]));
        }
        Pace::Hertz(chance.pick(&[40.0, 150.0]))
    }

    /// A planner process for some of the robots.
    pub(crate) fn seat(self, seed: u64, chance: &mut Chance) -> Seat {
        match self {
            Missions::Scouts => return scouts::seat(seed, chance),
            Missions::Accompanied => return accompanied::seat(seed, chance),
            Missions::Mixed => return mixed::seat(seed, chance),
            Missions::Hopper | Missions::Rovers | Missions::Protocol => {}
        }
        let planner = self.algorithm(chance);
        let robots = match self {
            Missions::Hopper | Missions::Protocol => RobotSet::default(),
            _ => RobotSet(chance.between(1, (1 << self.robots(seed)) - 1) as u16),
        };
        Seat { planner, robots }
    }

    /// A planner process for each robot, or one for the first two.
    fn planners(self, seed: u64, chance: &mut Chance) -> Vec<Seat> {
        match self {
            Missions::Scouts => return scouts::planners(seed, chance),
            Missions::Accompanied => return accompanied::planners(seed, chance),
            Missions::Mixed => return mixed::planners(seed, chance),
            Missions::Hopper | Missions::Rovers | Missions::Protocol => {}
        }
        let count = self.robots(seed);
        let mut left = RobotSet::first(count);
        let mut seats = Vec::new();
        if self == Missions::Rovers && chance.one_in(3) && count > 1 {
            seats.push(Seat { planner: self.algorithm(chance), robots: RobotSet::first(2) });
            left = RobotSet(left.0 & !3);
        }
        let own = |robot| Seat { planner: self.algorithm(chance), robots: RobotSet(0).with(robot) };
        seats.extend(left.iter().map(own));
        seats
    }
}

/// The quick ones more often.
const HOPPER_PLANNERS: [&str; 8] =
    ["greedy", "greedy", "greedy", "astar", "astar", "dstar_lite", "mdp", "hold"];

/// Rovers that cover a small piece of ground with obstacles.
fn rover_mission(seed: u64, number: u64) -> Mission {
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "rovers");
    let count = Missions::Rovers.robots(seed);
    let side = |chance: &mut Chance| chance.between(3, 5) as u32;
    let mut grid = Grid::new(side(&mut chance), side(&mut chance), 1.0, 1).expect("a small grid is a grid");
    if long::is_long(seed) && number == 0 {
        grid = long::covered_grid();
    }
    let (right, top) = (grid.width as i32 - 1, grid.height as i32 - 1);
    let corners = [Cell::new(0, 0), Cell::new(right, 0), Cell::new(0, top)];
    let starts = &corners[..usize::from(count)];
    let ground = |cell: Cell, chance: &mut Chance| Ground {
        height_m: 0.5 * chance.unit(),
        passable: starts.contains(&cell) || !chance.one_in(7),
        ..Ground::FLAT
    };
    let cells = grid.iter().map(|cell| ground(cell, &mut chance)).collect();
    let robot = |start: &Cell| Robot {
        body: Body::Rover(Rover { speed_mps: chance.pick(&[0.3, 0.5, 1.0, 1.0, 2.0]) }),
        sensor: Sensor::Square(Square { range_cells: chance.pick(&[1, 1, 2]) }),
        start: Placement { cell: *start, heading: chance.pick(&Direction::ALL) },
        start_at: Waypoint::middle_of(&grid, *start),
        goal: Goal::Cover(Cover::default()),
        required: true,
    };
    let mut robots: Vec<Robot> = starts.iter().map(robot).collect();
    let fault = |robot: RobotId| chance.one_in(6).then(|| Fault { robot, action: chance.between(2, 9) });
    let faults = (0..count).map(RobotId).filter_map(fault).collect();
    let brief = brief_of(&mut chance, Account::ActionsWithoutWaits, grid);
    let deadline_ns = guard(seed, number).deadline_ns;
    let limits = Limits { steps_max: chance.between(8, 24), decision_budget_ns: 600_000_000 };
    let cover = Cover {
        percent: chance.pick(&[60, 90, 100]),
        mode: chance.pick(&[CoverMode::Overlap, CoverMode::Voronoi]),
    };
    // Drawn last, so that seeds keep their robots.
    robots.iter_mut().for_each(|robot| robot.goal = Goal::Cover(cover));
    let brief = Brief { limits, guard: Guard { deadline_ns, ..BRIEF.guard }, robots: team(&robots), ..brief };
    let terrain = Terrain { grid, cells, treasures: Vec::new(), prior: Vec::new() };
    Mission { faults, ..Mission::under_law(brief, terrain, chance.bits()) }
}

fn hopper_mission(seed: u64, number: u64, vertical: Vertical) -> Mission {
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "mission");
    let side = |chance: &mut Chance| chance.between(4, 7) as u32;
    let grid = Grid::new(side(&mut chance), side(&mut chance), 1.0, 1).expect("a small grid is a grid");
    let corner = |chance: &mut Chance, far: bool| {
        let along = |chance: &mut Chance, side: u32| {
            let step = chance.below(2) as i32;
            if far { side as i32 - 1 - step } else { step }
        };
        Cell::new(along(chance, grid.width), along(chance, grid.height))
    };
    let (start, goal) = (corner(&mut chance, false), corner(&mut chance, true));
    let heights = heights(&mut Chance::new(seed ^ number.rotate_left(32), "heights"), grid);
    let cells = grid.iter().map(|cell| ground(&mut chance, grid, &heights, cell, &[start, goal])).collect();
    let treasures =
        grid.iter().filter(|cell| *cell != start && chance.one_in(14)).take(TREASURES_MAX).collect();
    let brief = brief_of(&mut chance, Account::Hopper, grid);
    let mut brief = Brief {
        profile: chance.pick(&PROFILES),
        limits: Limits { steps_max: chance.between(16, 48), decision_budget_ns: 600_000_000 },
        guard: guard(seed, number),
        ..brief
    };
    if vertical.is_paper_2022 {
        brief.profile = Profile::Paper2022;
    }
    let is_measured = brief.profile != Profile::Hopper;
    // Radii of 1 to 4 m, so that discs differ from landing to landing.
    let sensor = SensorParameters {
        gain: chance.pick(&[2.0, 2.5]),
        offset_m: 0.4,
        radius_min_m: 1.0,
        radius_max_m: 4.0,
        gradient: if is_measured { GradientSource::Measured } else { GradientSource::SeenDifferences },
    };
    let known_m = 2.0 * grid.hop_distance_m() * f64::from(grid.width.max(grid.height));
    let sensor = match vertical.knows_map {
        true => SensorParameters { radius_min_m: known_m, radius_max_m: known_m, ..sensor },
        false => sensor,
    };
    brief.payoff.treasure = chance.pick(&[0.0, 10.0, 60.0]);
    let motion = MotionParameters { vertical: vertical.hops, ..motion() };
    let mut hopper = Robot::hopper(&grid, motion, sensor, [start, goal]);
    if let Some(visit) = visits(seed, number, [goal, start]) {
        hopper.goal = Goal::Visit(visit);
    }
    brief.robots = team(&[hopper]);
    let terrain = Terrain { grid, cells, treasures, prior: Vec::new() };
    let dynamics =
        if vertical.hops { Dynamics::Collision(CollisionRules::default()) } else { dynamics(seed, number) };
    Mission { dynamics, ..Mission::under_law(brief, terrain, chance.bits()) }
}

/// The profiles of most missions; that of the predecessor paper goes with [`Vertical`].
const PROFILES: [Profile; 2] = [Profile::Paper2023, Profile::Hopper];

/// What a hopper has of the predecessor paper: drawn by itself, so that seeds keep all else.
struct Vertical {
    /// The vertical hop, and so collisions.
    hops: bool,
    /// A map that is known from the start.
    knows_map: bool,
    /// The payoff of that paper.
    is_paper_2022: bool,
}

impl Vertical {
    /// Nothing of it.
    const NONE: Self = Self { hops: false, knows_map: false, is_paper_2022: false };

    /// That of a mission; long ones have nothing of it.
    fn of(seed: u64, number: u64) -> Self {
        if long::is_long(seed) {
            return Self::NONE;
        }
        let mut chance = Chance::new(seed ^ number.rotate_left(32), "vertical");
        let hops = chance.one_in(4);
        let (knows_map, is_paper_2022) = (chance.one_in(2), chance.one_in(3));
        Self { hops, knows_map: hops && knows_map, is_paper_2022: hops && is_paper_2022 }
    }
}

/// The motion model of a mission with hoppers: mostly the law, physics in one of three.
fn dynamics(seed: u64, number: u64) -> Dynamics {
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "dynamics");
    match chance.below(6) {
        0 | 1 => Dynamics::Contact(ContactRules::default()),
        2 => Dynamics::Collision(CollisionRules::default()),
        _ => Dynamics::default(),
    }
}

/// How hops of the paper's hopper slip and drift.
fn motion() -> MotionParameters {
    let (motion, _) = BRIEF.robots[0].as_hopper().expect("the built-in scenario is a hopper's");
    *motion
}

/// The robots of a small mission.
fn team(robots: &[Robot]) -> Robots {
    Robots::new(robots).expect("small missions have few robots")
}

/// What the briefs of all missions have in common: a run and a scenario of their own.
fn brief_of(chance: &mut Chance, account: Account, grid: Grid) -> Brief {
    let mut scenario_hash = [0; 32];
    scenario_hash[..8].copy_from_slice(&chance.bits().to_le_bytes());
    Brief {
        run: RunId(u128::from(chance.bits()) << 64 | u128::from(chance.bits() | 1)),
        scenario: "simulated".parse().expect("a name"),
        scenario_hash,
        profile: Profile::Hopper,
        account,
        grid,
        ..BRIEF.clone()
    }
}

/// Heights over a range of at least one metre: a slope across the map, and roughness.
fn heights(chance: &mut Chance, grid: Grid) -> Vec<f64> {
    let range_m = 1.0 + 0.5 * chance.unit();
    let (along, up) = (chance.unit(), chance.below(2) == 0);
    let place = |cell: Cell| {
        let x = f64::from(cell.x) / f64::from(grid.width - 1);
        let y = f64::from(cell.y) / f64::from(grid.height - 1);
        let share = along * x + (1.0 - along) * y;
        if up { share } else { 1.0 - share }
    };
    grid.iter().map(|cell| range_m * place(cell) + 0.3 * chance.unit() - 0.1).collect()
}

/// Now and then visits there and back.
fn visits(seed: u64, number: u64, goals: [Cell; 2]) -> Option<Visit> {
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "patrol");
    let hops_max = chance.between(12, 40);
    chance.one_in(5).then(|| Visit::new(&goals, hops_max).expect("start and goal differ"))
}

/// The guard of a mission: none, one that forbids but the grossest, one that forbids much or all that is
/// dangerous; and now and then a deadline that is short beside what planners and restarts take.
fn guard(seed: u64, number: u64) -> Guard {
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "guard");
    Guard {
        hazard_max: chance.pick(&[1.0, 0.25, 0.25, 0.06, 0.0]),
        deadline_ns: chance.pick(&[0, 0, 20_000_000, 250_000_000, 1_200_000_000]),
    }
}

fn ground(chance: &mut Chance, grid: Grid, heights: &[f64], cell: Cell, kept: &[Cell]) -> Ground {
    let height = |dx: i32, dy: i32| {
        let neighbour = grid.index(Cell::new(cell.x + dx, cell.y + dy)).or(grid.index(cell));
        heights[neighbour.expect("a cell of the grid")]
    };
    let rock = chance.one_in(12) && !kept.contains(&cell);
    Ground {
        height_m: height(0, 0),
        gradient: [(height(1, 0) - height(-1, 0)) / 2.0, (height(0, 1) - height(0, -1)) / 2.0],
        soil: if chance.one_in(4) { Soil::Sand } else { Soil::Hard },
        passable: !rock,
        ..Ground::FLAT
    }
}
