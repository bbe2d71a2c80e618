//! A rover that drives to a goal over a small map of uncertain speed, with one or two helicopters.

use contract::{
    Account, Body, Brief, Camera, Direction, DriveSpeed, Driver, ErringCamera, Goal, Grid, Ground, Guard,
    Helicopter, Limits, LookAhead, Placement, Reach, Robot, RobotId, RobotSet, Sampling, Sensor, SpeedPrior,
    Track, Waypoint,
};
use hopper_sim::Mission;
use scenario::Fault;
use terrain::Terrain;

use super::{Missions, Seat, brief_of, guard, team};
use crate::chance::Chance;

/// Distance from start and goal up to which the ground is good for certain, metres.
pub(super) const GOOD_M: f64 = 1.5;

/// Speed of all ground that is certain where missions have several stages: a stage then is 50 m long.
const LONG_SPEED: DriveSpeed = DriveSpeed::Slow;

/// Ground with one prior and one true speed.
pub(super) struct Region {
    middle: Waypoint,
    radius_m: f64,
    pub prior: SpeedPrior,
    pub speed: DriveSpeed,
}

/// The number of the rover; the other robots are helicopters.
fn rover(seed: u64) -> RobotId {
    let count = Missions::Scouts.robots(seed);
    let mut chance = Chance::new(seed, "rover");
    RobotId(if chance.one_in(4) { chance.below(count.into()) as u16 } else { 0 })
}

/// A planner process for the rover, or for some of the helicopters; now and then for robots that it cannot plan for.
pub(super) fn seat(seed: u64, chance: &mut Chance) -> Seat {
    let (count, rover) = (Missions::Scouts.robots(seed), rover(seed));
    if chance.one_in(16) {
        let robots = RobotSet(chance.between(1, (1 << count) - 1) as u16);
        return Seat { planner: Missions::Scouts.algorithm(chance), robots };
    }
    let helicopters = RobotSet::first(count).0 & !(1 << rover.0);
    let some = helicopters & chance.between(1, (1 << count) - 1) as u16;
    if some == 0 { of_rover(rover, chance) } else { of_helicopters(some, chance) }
}

fn of_rover(rover: RobotId, chance: &mut Chance) -> Seat {
    let planner = chance.pick(planner::DRIVE_ALGORITHMS).parse().expect("the names of algorithms are names");
    Seat { planner, robots: RobotSet(0).with(rover) }
}

fn of_helicopters(robots: u16, chance: &mut Chance) -> Seat {
    let planner = chance.pick(planner::FLY_ALGORITHMS).parse().expect("the names of algorithms are names");
    Seat { planner, robots: RobotSet(robots) }
}

/// A planner process for the rover, and one for each helicopter or for both.
pub(super) fn planners(seed: u64, chance: &mut Chance) -> Vec<Seat> {
    let (count, rover) = (Missions::Scouts.robots(seed), rover(seed));
    let helicopters = RobotSet(RobotSet::first(count).0 & !(1 << rover.0));
    let mut seats = vec![of_rover(rover, chance)];
    if chance.one_in(3) {
        seats.push(of_helicopters(helicopters.0, chance));
    } else {
        seats.extend(helicopters.iter().map(|robot| of_helicopters(1 << robot.0, chance)));
    }
    seats
}

/// The `number`th mission of a seed.
pub(super) fn mission(seed: u64, number: u64) -> Mission {
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "scouts");
    let (count, rover) = (Missions::Scouts.robots(seed), rover(seed));
    let side = |chance: &mut Chance| chance.between(10, 16) as u32;
    // Drawn apart, so that all else is the same in a mission of one stage.
    let mut staging = Chance::new(seed ^ number.rotate_left(32), "stages");
    let stages = if staging.one_in(4) { staging.between(2, 3) as u32 } else { 1 };
    let (mut width, mut height) = (side(&mut chance), side(&mut chance));
    if stages > 1 {
        (width, height) = (staging.between(60, 120) as u32, staging.between(4, 8) as u32);
    }
    let grid = Grid::new(width, height, 1.0, 1).expect("a small grid is a grid");
    let (width_m, height_m) = (f64::from(grid.width), f64::from(grid.height));
    let across = |chance: &mut Chance, side_m: f64| 0.5 + (side_m - 1.0) * chance.unit();
    let start = Waypoint { x_m: 0.5 + chance.unit(), y_m: across(&mut chance, height_m) };
    let goal = Waypoint { x_m: width_m - 0.5 - chance.unit(), y_m: across(&mut chance, height_m) };
    let certain = if stages > 1 { LONG_SPEED } else { DriveSpeed::Fast };
    let mut terrain = terrain(&mut chance, grid, certain, [start, goal]);
    // Drawn apart, so that all else is the same whether a camera errs or not.
    let mut errors = Chance::new(seed, "errors of cameras");
    let accuracy = errors.one_in(3).then(|| errors.pick(&[0.5, 0.9, 0.99]));
    if let Some(accuracy) = accuracy {
        read(&mut errors, accuracy, &mut terrain);
    }
    let mut robot = |chance: &mut Chance, number: u16| {
        let cell = grid.cell((start.y_m as usize) * grid.width as usize + start.x_m as usize);
        let required = number == rover.0;
        let (body, sensor, goal) = if required {
            let reach = Reach { at: goal, radius_m: chance.pick(&[0.5, 1.0, 3.0]) };
            (Body::Driver(Driver {}), Sensor::Track(Track {}), Goal::Reach(reach))
        } else {
            let (speed_mps, budget_m) = (chance.pick(&[0.002, 0.5, 5.0]), chance.pick(&[6.0, 15.0, 40.0]));
            let radius_m = chance.pick(&[0.8, 1.5, 2.5]);
            let sensor = match accuracy {
                // Now and then one that errs flies beside one that does not.
                Some(accuracy) if !errors.one_in(4) => {
                    Sensor::ErringCamera(ErringCamera { radius_m, accuracy })
                }
                _ => Sensor::Camera(Camera { radius_m }),
            };
            let body = Body::Helicopter(Helicopter { speed_mps, budget_m });
            (body, sensor, Goal::LookAhead(LookAhead {}))
        };
        let start_cell = Placement { cell, heading: chance.pick(&Direction::ALL) };
        Robot { body, sensor, start: start_cell, start_at: start, goal, required }
    };
    let robots: Vec<Robot> = (0..count).map(|number| robot(&mut chance, number)).collect();
    let fault = |robot: RobotId| chance.one_in(5).then(|| Fault { robot, action: chance.between(1, 8) });
    let faults = (0..count).map(RobotId).filter_map(fault).collect();
    let brief = brief_of(&mut chance, Account::Actions, grid);
    let brief = Brief {
        limits: Limits {
            steps_max: chance.between(10, 24) * u64::from(stages),
            decision_budget_ns: 600_000_000,
        },
        guard: Guard { hazard_max: chance.pick(&[1.0, 1.0, 0.3, 0.01]), ..guard(seed, number) },
        sampling: Some(Sampling {
            seed: chance.bits(),
            // A long way takes more samples.
            rover_samples: chance.between(10, 40) as u32 * if stages > 1 { 8 } else { 1 },
            helicopter_samples: chance.between(10, 40) as u32,
            stages,
        }),
        robots: team(&robots),
        ..brief
    };
    Mission { faults, ..Mission::under_law(brief, terrain, chance.bits()) }
}

/// Adds what a camera that is right so often reads of each cell.
pub(super) fn read(chance: &mut Chance, accuracy: f64, terrain: &mut Terrain) {
    for ground in &mut terrain.cells {
        let is_right = chance.unit() < accuracy;
        let others: Vec<DriveSpeed> =
            DriveSpeed::ALL.into_iter().filter(|speed| Some(*speed) != ground.speed).collect();
        ground.reading = if is_right { ground.speed } else { Some(chance.pick(&others)) };
    }
}

/// Ground of that speed with discs that may be faster, slower or a trap, none of them around a point of `kept`.
fn terrain(chance: &mut Chance, grid: Grid, good: DriveSpeed, kept: [Waypoint; 2]) -> Terrain {
    let regions: Vec<Region> = (0..chance.between(2, 6)).map(|_| region(chance, grid)).collect();
    let is_kept = |middle: Waypoint| kept.iter().any(|point| point.distance_m(middle) <= GOOD_M);
    let relief_m = chance.pick(&[0.0, 0.5]);
    let mut heights = chance.clone();
    let (cells, prior) = grid
        .iter()
        .map(|cell| {
            let middle = Waypoint { x_m: f64::from(cell.x) + 0.5, y_m: f64::from(cell.y) + 0.5 };
            let (speed, prior) = match region_at(&regions, middle) {
                Some(region) if !is_kept(middle) => (region.speed, region.prior),
                _ => (good, certain(good)),
            };
            let height_m = relief_m * heights.unit();
            (Ground { speed: Some(speed), height_m, ..Ground::FLAT }, prior)
        })
        .unzip();
    Terrain { grid, cells, treasures: Vec::new(), prior }
}

/// The prior of ground of that speed for certain.
pub(super) fn certain(speed: DriveSpeed) -> SpeedPrior {
    let mut probabilities = [0.0; 4];
    probabilities[speed as usize] = 1.0;
    SpeedPrior::new(probabilities).expect("a certainty adds up")
}

/// The first region in which a point lies.
pub(super) fn region_at(regions: &[Region], at: Waypoint) -> Option<&Region> {
    regions.iter().find(|region| region.middle.distance_m(at) <= region.radius_m)
}

pub(super) fn region(chance: &mut Chance, grid: Grid) -> Region {
    let middle =
        Waypoint { x_m: f64::from(grid.width) * chance.unit(), y_m: f64::from(grid.height) * chance.unit() };
    let probabilities = match chance.below(4) {
        0 => [1.0, 0.0, 0.0, 0.0],
        1 => {
            let trap = chance.pick(&[0.005, 0.1, 0.25, 0.5, 0.75]);
            [trap, 0.0, 0.0, 1.0 - trap]
        }
        2 => chance.pick(&[[0.0, 0.5, 0.25, 0.25], [0.0, 0.125, 0.125, 0.75], [0.0, 0.75, 0.0, 0.25]]),
        _ => [0.0, 1.0, 0.0, 0.0],
    };
    let mut left = chance.unit();
    let drawn = DriveSpeed::ALL.into_iter().find(|speed| {
        left -= probabilities[*speed as usize];
        left < 0.0
    });
    Region {
        middle,
        radius_m: 1.0 + 3.0 * chance.unit(),
        prior: SpeedPrior::new(probabilities).expect("the probabilities add up"),
        speed: drawn.unwrap_or(DriveSpeed::Fast),
    }
}
