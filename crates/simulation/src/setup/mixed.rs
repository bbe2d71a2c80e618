//! Robots of all kinds on a small map, each with a goal of its own.

use contract::limits::TREASURES_MAX;
use contract::{
    Account, Body, Brief, Camera, Cell, Cover, CoverMode, Direction, DriveSpeed, Driver, ErringCamera, Goal,
    GradientSource, Grid, Guard, Helicopter, Hopper, Limits, LookAhead, MotionParameters, Placement, Profile,
    Reach, Robot, RobotId, RobotSet, Rover, Sampling, Sensor, SensorParameters, SoilMotion, SpeedPrior,
    Square, Track, Waypoint,
};
use hopper_sim::Mission;
use scenario::Fault;
use terrain::Terrain;

use super::scouts::{GOOD_M, certain, read, region, region_at};
use super::{
    BRIEF, HOPPER_PLANNERS, Missions, PROFILES, Seat, brief_of, dynamics, ground, guard, heights, motion,
    team,
};
use crate::chance::Chance;

/// Hops within which a hopper's goal is.
const WAY_HOPS: i32 = 4;

/// Most designs of hoppers in a mission, beside the usual one.
const DESIGNS_MAX: usize = 4;

/// Side of the part of the map on which all begin in every other mission, cells: so they meet.
const CROWD_CELLS: i32 = 5;

/// What a robot is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A hopper with a goal.
    Hopper,
    /// A rover with a goal.
    Driver,
    /// A rover that covers ground.
    Rover,
    Helicopter,
}

/// What the robots of a seed are to do, the same in all its missions; one of them at least is on the ground.
fn kinds(seed: u64) -> Vec<Kind> {
    use Kind::{Driver, Helicopter, Hopper, Rover};
    let mut chance = Chance::new(seed, "kinds");
    let some = [Hopper, Hopper, Hopper, Hopper, Rover, Rover, Driver, Driver, Helicopter, Helicopter];
    let mut kinds: Vec<Kind> = (0..chance.between(2, 5)).map(|_| chance.pick(&some)).collect();
    if kinds.iter().all(|kind| *kind == Helicopter) {
        kinds[0] = chance.pick(&[Hopper, Rover, Driver]);
    }
    kinds
}

/// How many robots the missions of a seed have.
pub(super) fn robots(seed: u64) -> u16 {
    kinds(seed).len() as u16
}

/// The robots of that kind.
fn those(kinds: &[Kind], kind: Kind) -> RobotSet {
    let robots = (0..).map(RobotId).zip(kinds).filter(|(_, other)| **other == kind);
    robots.fold(RobotSet(0), |set, (robot, _)| set.with(robot))
}

/// A planner process for some robots of a kind.
fn of_kind(kinds: &[Kind], kind: Kind, robots: RobotSet, chance: &mut Chance) -> Seat {
    let looks_for_hoppers = !kinds.contains(&Kind::Driver) || chance.one_in(4);
    let planner = match kind {
        Kind::Hopper => chance.pick(&HOPPER_PLANNERS),
        Kind::Driver => chance.pick(planner::DRIVE_ALGORITHMS),
        Kind::Rover => chance.pick(planner::COVER_ALGORITHMS),
        Kind::Helicopter if looks_for_hoppers => planner::AHEAD_ALGORITHMS[0],
        Kind::Helicopter => chance.pick(planner::FLY_ALGORITHMS),
    };
    Seat { planner: planner.parse().expect("the names of algorithms are names"), robots }
}

/// A planner process for some robots of one kind; now and then for robots that it cannot plan for.
pub(super) fn seat(seed: u64, chance: &mut Chance) -> Seat {
    let kinds = kinds(seed);
    let some = RobotSet(chance.between(1, (1 << kinds.len()) - 1) as u16);
    if chance.one_in(16) {
        return Seat { planner: Missions::Mixed.algorithm(chance), robots: some };
    }
    let kind = chance.pick(&kinds);
    let all = those(&kinds, kind);
    let some = RobotSet(some.0 & all.0);
    of_kind(&kinds, kind, if some.0 == 0 { all } else { some }, chance)
}

/// A planner process for each robot, or one for all of a kind.
pub(super) fn planners(seed: u64, chance: &mut Chance) -> Vec<Seat> {
    let kinds = kinds(seed);
    let mut seats = Vec::new();
    for kind in [Kind::Hopper, Kind::Driver, Kind::Rover, Kind::Helicopter] {
        let all = those(&kinds, kind);
        if all.0 != 0 && chance.one_in(3) {
            seats.push(of_kind(&kinds, kind, all, chance));
        } else {
            seats.extend(all.iter().map(|robot| of_kind(&kinds, kind, RobotSet(0).with(robot), chance)));
        }
    }
    seats
}

/// Where robots begin, and where those go that have a goal of their own.
struct Places {
    grid: Grid,
    /// Columns and rows on which robots begin.
    crowd: [i32; 2],
    starts: Vec<Cell>,
    goals: Vec<Cell>,
    /// Where rovers begin that cover ground, which is nobody's goal.
    covered: Vec<Cell>,
}

impl Places {
    fn new(grid: Grid, chance: &mut Chance) -> Self {
        let sides = [grid.width as i32, grid.height as i32];
        let crowd = if chance.one_in(2) { sides.map(|side| side.min(CROWD_CELLS)) } else { sides };
        Self { grid, crowd, starts: Vec::new(), goals: Vec::new(), covered: Vec::new() }
    }

    /// A cell on which no other begins.
    fn start(&mut self, chance: &mut Chance) -> Cell {
        let free: Vec<Cell> = self
            .grid
            .iter()
            .filter(|cell| cell.x < self.crowd[0] && cell.y < self.crowd[1] && !self.starts.contains(cell))
            .collect();
        let start = chance.pick(&free);
        self.starts.push(start);
        start
    }

    /// A start for a rover that covers ground, which is nobody's goal either.
    fn start_to_cover(&mut self, chance: &mut Chance) -> Cell {
        loop {
            let start = self.start(chance);
            if !self.goals.contains(&start) {
                self.covered.push(start);
                return start;
            }
        }
    }

    /// A cell some hops of `hop_cells` from `start` which is no other's goal.
    fn goal(&mut self, chance: &mut Chance, start: Cell, hop_cells: i32) -> Cell {
        let hops = |cell: &Cell| ((cell.x - start.x).abs() + (cell.y - start.y).abs()) / hop_cells;
        let is_in_reach = |cell: &Cell| (1..=WAY_HOPS).contains(&hops(cell));
        let is_on_lattice =
            |cell: &Cell| (cell.x - start.x) % hop_cells == 0 && (cell.y - start.y) % hop_cells == 0;
        let free: Vec<Cell> = self
            .grid
            .iter()
            .filter(|cell| is_on_lattice(cell) && is_in_reach(cell))
            .filter(|cell| !self.goals.contains(cell) && !self.covered.contains(cell))
            .collect();
        let goal = chance.pick(&free);
        self.goals.push(goal);
        goal
    }
}

/// A robot of that kind; of one that flies, the camera errs where it is right only so often. How it hops, how much it shall cover and
/// whether the mission requires it is drawn later.
fn robot(kind: Kind, places: &mut Places, accuracy: Option<f64>, chance: &mut Chance) -> Robot {
    let (grid, heading) = (places.grid, chance.pick(&Direction::ALL));
    let of = |body, sensor, cell, goal| Robot {
        body,
        sensor,
        start: Placement { cell, heading },
        start_at: Waypoint::middle_of(&grid, cell),
        goal,
        required: false,
    };
    let within = |cell: Cell, chance: &mut Chance| Waypoint {
        x_m: f64::from(cell.x) + 0.3 + 0.4 * chance.unit(),
        y_m: f64::from(cell.y) + 0.3 + 0.4 * chance.unit(),
    };
    if kind == Kind::Helicopter {
        let cell = chance.pick(&grid.iter().collect::<Vec<_>>());
        let (speed_mps, budget_m) =
            (chance.pick(&[0.2, 0.5, 5.0]), chance.pick(&[0.0, 2.5, 6.0, 15.0, 40.0]));
        let radius_m = chance.pick(&[0.8, 1.5, 2.5]);
        // Now and then one that errs flies beside one that does not.
        let sensor = match accuracy {
            Some(accuracy) if !chance.one_in(4) => Sensor::ErringCamera(ErringCamera { radius_m, accuracy }),
            _ => Sensor::Camera(Camera { radius_m }),
        };
        let body = Body::Helicopter(Helicopter { speed_mps, budget_m });
        return of(body, sensor, cell, Goal::LookAhead(LookAhead {}));
    }
    let cell = if kind == Kind::Rover { places.start_to_cover(chance) } else { places.start(chance) };
    match kind {
        Kind::Hopper => {
            let goal = places.goal(chance, cell, grid.hop_cells as i32);
            let body = Body::Hopper(Hopper { motion: motion() });
            of(body, BRIEF.robots[0].sensor, cell, Goal::Reach(Reach::of_cell(&grid, goal)))
        }
        Kind::Driver => {
            let (start_at, goal) = (within(cell, chance), places.goal(chance, cell, 1));
            let (at, radius_m) = (within(goal, chance), chance.pick(&[0.3, 0.5, 1.0, 3.0]));
            let goal = Goal::Reach(Reach { at, radius_m });
            Robot { start_at, ..of(Body::Driver(Driver {}), Sensor::Track(Track {}), cell, goal) }
        }
        _ => {
            let speed_mps = chance.pick(&[0.3, 0.5, 1.0, 1.0, 2.0]);
            let sensor = Sensor::Square(Square { range_cells: chance.pick(&[1, 1, 2]) });
            of(Body::Rover(Rover { speed_mps }), sensor, cell, Goal::Cover(Cover::default()))
        }
    }
}

/// Ground for hoppers, with speeds if rovers shall drive over it: certainly fast around the ends of their ways.
fn terrain(seed: u64, grid: Grid, places: &Places, has_speeds: bool, chance: &mut Chance) -> Terrain {
    let heights = heights(&mut Chance::new(seed, "mixed heights"), grid);
    let kept = [&places.starts[..], &places.goals[..]].concat();
    let mut cells: Vec<_> = grid.iter().map(|cell| ground(chance, grid, &heights, cell, &kept)).collect();
    let treasures =
        grid.iter().filter(|cell| !kept.contains(cell) && chance.one_in(12)).take(TREASURES_MAX).collect();
    let mut prior = Vec::new();
    if has_speeds {
        let regions: Vec<_> = (0..chance.between(2, 6)).map(|_| region(chance, grid)).collect();
        let ends: Vec<Waypoint> = kept.iter().map(|cell| Waypoint::middle_of(&grid, *cell)).collect();
        let of_cell = |cell: Cell| -> (DriveSpeed, SpeedPrior) {
            let middle = Waypoint::middle_of(&grid, cell);
            let is_kept = ends.iter().any(|end| end.distance_m(middle) <= GOOD_M / 2.0);
            match region_at(&regions, middle) {
                Some(region) if !is_kept => (region.speed, region.prior),
                _ => (DriveSpeed::Fast, certain(DriveSpeed::Fast)),
            }
        };
        for (ground, cell) in cells.iter_mut().zip(grid.iter()) {
            let (speed, of_speeds) = of_cell(cell);
            ground.speed = Some(speed);
            prior.push(of_speeds);
        }
    }
    Terrain { grid, cells, treasures, prior }
}

/// The `number`th mission of a seed.
pub(super) fn mission(seed: u64, number: u64) -> Mission {
    let own_seed = seed ^ number.rotate_left(32);
    let mut chance = Chance::new(own_seed, "mixed");
    let kinds = kinds(seed);
    let has = |kind| kinds.contains(&kind);
    let has_speeds = has(Kind::Driver) || chance.one_in(2);
    let hop_cells = if chance.one_in(4) { 2 } else { 1 };
    let (width, height) = (chance.between(7, 14) as u32, chance.between(6, 12) as u32);
    let grid = Grid::new(width, height, 1.0, hop_cells).expect("a small grid is a grid");
    let accuracy = (has_speeds && chance.one_in(3)).then(|| chance.pick(&[0.5, 0.9, 0.99]));
    let mut places = Places::new(grid, &mut chance);
    let mut robots: Vec<Robot> =
        kinds.iter().map(|kind| robot(*kind, &mut places, accuracy, &mut chance)).collect();
    let mut terrain = terrain(own_seed, grid, &places, has_speeds, &mut chance);
    if let Some(accuracy) = accuracy
        && robots.iter().any(|robot| robot.sensor.accuracy().is_some())
    {
        read(&mut chance, accuracy, &mut terrain);
    }
    let count = robots.len() as u16;
    let fault = |robot: RobotId| chance.one_in(6).then(|| Fault { robot, action: chance.between(1, 10) });
    let faults = (0..count).map(RobotId).filter_map(fault).collect();
    let brief = brief_of(&mut chance, Account::ActionsWithoutWaits, grid);
    let brief = Brief {
        profile: chance.pick(&PROFILES),
        limits: Limits { steps_max: chance.between(8, 26), decision_budget_ns: 600_000_000 },
        guard: Guard { hazard_max: chance.pick(&[1.0, 1.0, 0.3, 0.06, 0.0]), ..guard(seed, number) },
        ..brief
    };
    let percent = has(Kind::Rover).then(|| chance.pick(&[2, 5, 10, 25, 100]));
    let mut brief = Brief {
        sampling: has(Kind::Driver).then(|| Sampling {
            seed: chance.bits(),
            rover_samples: chance.between(10, 40) as u32,
            helicopter_samples: chance.between(10, 40) as u32,
            stages: 1,
        }),
        ..brief
    };
    let required = required(&kinds, &mut chance);
    let measures = brief.profile == Profile::Paper2023 || !has(Kind::Hopper);
    let sensor = SensorParameters {
        gain: chance.pick(&[1.0, 2.0]),
        offset_m: 0.4,
        radius_min_m: grid.hop_distance_m(),
        radius_max_m: 4.0,
        gradient: if measures { GradientSource::Measured } else { GradientSource::SeenDifferences },
    };
    brief.payoff.treasure = chance.pick(&[0.0, 10.0, 60.0]);
    brief.priors.treasures = terrain.treasures.len() as u32;
    let designs = designs(&kinds, (motion(), sensor), &mut chance);
    for ((number, robot), (motion, sensor)) in (0..).map(RobotId).zip(&mut robots).zip(designs) {
        robot.required = required.has(number);
        if robot.body.hops() {
            (robot.body, robot.sensor) = (Body::Hopper(Hopper { motion }), Sensor::Disc(sensor));
        }
        if let (Goal::Cover(cover), Some(percent)) = (&mut robot.goal, percent) {
            *cover = Cover { percent, mode: CoverMode::Overlap };
        }
    }
    brief.robots = team(&robots);
    let dynamics = dynamics(seed, number);
    Mission { dynamics, faults, ..Mission::under_law(brief, terrain, chance.bits()) }
}

/// How a hopper hops, and how far it sees.
type Design = (MotionParameters, SensorParameters);

/// How each robot hops and sees if it is a hopper: some of them more carefully than the `usual`, or further.
fn designs(kinds: &[Kind], usual: Design, chance: &mut Chance) -> Vec<Design> {
    let (motion, sensor) = usual;
    let mut other = |kind: &Kind| {
        let differs = *kind == Kind::Hopper && chance.one_in(2);
        differs.then(|| {
            let soil = |soil: SoilMotion, stuck| SoilMotion {
                intended: soil.intended - stuck,
                stuck: soil.stuck + stuck,
                ..soil
            };
            let stuck = chance.pick(&[0.0, 0.2]);
            let own = MotionParameters {
                hard: soil(motion.hard, stuck),
                sand: soil(motion.sand, stuck),
                launch_angle_rad: chance.pick(&[motion.launch_angle_rad, 1.2]),
                ..motion
            };
            (own, SensorParameters { gain: chance.pick(&[0.0, sensor.gain, 4.0]), ..sensor })
        })
    };
    let mut known: Vec<Design> = Vec::new();
    let design = |kind: &Kind| {
        let Some(own) = other(kind) else { return usual };
        if !known.contains(&own) && known.len() < DESIGNS_MAX {
            known.push(own);
        }
        if known.contains(&own) { own } else { usual }
    };
    kinds.iter().map(design).collect()
}

/// Most robots on the ground, one of them at least.
fn required(kinds: &[Kind], chance: &mut Chance) -> RobotSet {
    let grounded: Vec<RobotId> = (0..)
        .map(RobotId)
        .zip(kinds)
        .filter(|(_, kind)| **kind != Kind::Helicopter)
        .map(|(robot, _)| robot)
        .collect();
    let mut some = RobotSet(0);
    for robot in &grounded {
        if !chance.one_in(4) {
            some = some.with(*robot);
        }
    }
    if some.0 == 0 { RobotSet(0).with(grounded[0]) } else { some }
}

#[cfg(test)]
mod tests {
    use contract::wire::{BriefV10, RobotV1, brief_from_wire};

    use super::*;

    /// What is simulated could come from a scenario: the brief is one that messages carry, all on the ground begin apart, and the
    /// mission needs none that flies.
    #[test]
    fn every_mission_has_a_brief_of_the_wire_and_robots_apart() {
        for seed in 0..300 {
            let Mission { brief, terrain, .. } = mission(seed, seed % 3);
            let robots: Vec<RobotV1> = brief.robots.iter().map(RobotV1::from).collect();
            let read = brief_from_wire(&BriefV10::from(&brief), &robots);
            assert_eq!(read.as_ref(), Ok(&brief), "seed {seed}");
            let on_ground = brief.robots.iter().filter(|robot| robot.body.is_on_ground());
            let mut starts: Vec<Cell> = on_ground.map(|robot| robot.start.cell).collect();
            assert!(
                starts.iter().all(|start| terrain.ground(*start).is_some_and(|ground| ground.is_drivable()))
            );
            let count = starts.len();
            starts.sort();
            starts.dedup();
            assert_eq!(starts.len(), count, "seed {seed}");
            let mut required = brief.robots.iter().filter(|robot| robot.required).peekable();
            assert!(
                required.peek().is_some() && required.all(|robot| robot.body.is_on_ground()),
                "seed {seed}"
            );
        }
    }
}
