//! One world, flown and driven in each arm of the study.

use std::sync::Arc;

use helicopter::{BUDGET_M, Camera, Sensor, observe, scout};
use routing::{
    KeptClear, Route, RrtStarIt, ScoutValue, Trip, ett_exact_or_closer, rrt_star, rrt_star_ett, rrt_star_it,
    scout_route, scout_value, stage_seed,
};
use rover::{Allowance, Belief, Caution, DriveEnd, Point, SpeedDistribution, drive};
use scout_world::StageClock;
use serde::Serialize;

use crate::World;

/// What the rover is helped by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Arm {
    /// `rrt_star`: the shortest route, whatever the risk.
    NaiveRover,
    /// `rrt_star_ett` on the prior alone.
    SafeRover,
    /// The safe rover, with a helicopter along its route.
    ScoutRoute,
    /// The safe rover, with `rrt_star_it`.
    InformationTheoretic,
    /// The safe rover, with our `scout_value`.
    ScoutValue,
    /// The rover that knows the truth and takes the exact route, without clearance: the yardstick of all arms.
    Clairvoyant,
}

impl Arm {
    /// In the order of the tables.
    pub const ALL: [Self; 6] = [
        Self::NaiveRover,
        Self::SafeRover,
        Self::ScoutRoute,
        Self::InformationTheoretic,
        Self::ScoutValue,
        Self::Clairvoyant,
    ];

    /// The name in files, as it is serialised.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::NaiveRover => "naive_rover",
            Self::SafeRover => "safe_rover",
            Self::ScoutRoute => "scout_route",
            Self::InformationTheoretic => "information_theoretic",
            Self::ScoutValue => "scout_value",
            Self::Clairvoyant => "clairvoyant",
        }
    }

    /// The name for tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NaiveRover => "naive rover",
            Self::SafeRover => "safe rover",
            Self::ScoutRoute => "with naive helicopter",
            Self::InformationTheoretic => "with information-theoretic helicopter",
            Self::ScoutValue => "with scout_value",
            Self::Clairvoyant => "knowing the truth",
        }
    }
}

/// Which planner the safe rover uses in all arms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RoverPlanner {
    /// That of the paper.
    RrtStarEtt,
    /// Ours.
    EttExact,
}

/// How many samples the RRT* planners draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Samples {
    /// Samples of the rover's planners.
    pub rover: usize,
    /// Samples of the helicopter's planners.
    pub helicopter: usize,
}

impl Samples {
    /// Samples for 200 x 200 cells.
    pub const MONTE_CARLO: Self = Self { rover: 1200, helicopter: 600 };
    /// Samples for 821 x 821 cells.
    pub const LARGE: Self = Self { rover: 8000, helicopter: 3000 };
}

/// How a mission is flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Planner of the safe rover.
    pub planner: RoverPlanner,
    /// Samples that the RRT* planners draw.
    pub samples: Samples,
    /// Flights at most, each with a drive after it. One in the paper's studies.
    pub stages: u32,
    /// What the helicopter sees with, and the seed of its errors; without error if none.
    pub sensor: Option<(Sensor, u64)>,
    /// How far `ett_exact` keeps from forbidden cells, metres; 0 in the paper's studies. Nobody else keeps a distance, the rover that
    /// knows the truth neither.
    pub clearance_m: f64,
}

impl Setup {
    /// One flight with a sensor that does not err, as in the paper.
    #[must_use]
    pub fn new(planner: RoverPlanner, samples: Samples) -> Self {
        Self { planner, samples, stages: 1, sensor: None, clearance_m: 0.0 }
    }
}

/// What became of the rover.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Time to the goal, in Sol; none if the rover is stuck or found no route.
    pub travel_sol: Option<f64>,
    /// Whether it entered a cell of speed 0.
    pub stuck: bool,
    /// Expected time of the first route driven, under what was known at the start of the drive; infinite without a route.
    #[serde(skip)]
    pub expected_sol: f64,
    /// The route driven, the last one if there were several stages.
    #[serde(skip)]
    pub route: Vec<Point>,
    /// The helicopter's first flight; empty without one.
    #[serde(skip)]
    pub flight: Vec<Point>,
    /// Flights and drives one after the other, if a helicopter flies.
    #[serde(skip)]
    pub stages: Vec<Stage>,
}

/// A flight with the drive after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// The helicopter's flight, from where the rover stands.
    pub flight: Vec<Point>,
    /// The rover's route to the goal, as it was chosen after the flight.
    pub route: Vec<Point>,
    /// Where the drive along it ended.
    pub end: Point,
}

/// Plans, scouts, plans again and drives, stage by stage, in one arm.
///
/// `announced` is the safe rover's route on the prior, which the arms of one world share; see [`announce`].
#[must_use]
pub fn fly(world: &World, arm: Arm, setup: &Setup, seed: u64, announced: Option<&Route>) -> Outcome {
    if arm == Arm::NaiveRover {
        let route = rrt_star(&world.prior.distance(), &world.trip, setup.samples.rover, seed);
        return driven(world, route);
    }
    if arm == Arm::SafeRover {
        return driven(world, announced.cloned());
    }
    let mut belief = world.prior.clone();
    let exact = Setup { planner: RoverPlanner::EttExact, clearance_m: 0.0, ..*setup };
    let setup = if arm == Arm::Clairvoyant { &exact } else { setup };
    if arm == Arm::Clairvoyant {
        belief = world.truth.known(Arc::clone(belief.surface())).expect("a speed for each cell");
    }
    let mut trip = world.trip;
    let mut announced = announced.cloned();
    let mut outcome: Option<Outcome> = None;
    let mut spent_sol = 0.0;
    let mut clock = StageClock::new(setup.stages);
    for stage in 1..=setup.stages {
        let seed = stage_seed(seed, stage);
        let flight = flight(&belief, &trip, arm, setup, seed, announced.as_ref());
        look(&mut belief, world, &flight, setup);
        let costs = belief.expected_time(Caution::default());
        // Another seed than before: the same samples would give the same tree where nothing is new.
        let again = plan(&belief, &trip, setup, !seed);
        let clearance_m = again.as_ref().map_or(0.0, |(_, clearance_m)| *clearance_m);
        let kept = announced.map(|route| {
            let cost = KeptClear::new(&costs, &trip, clearance_m).way(&route.points);
            Route { points: route.points, cost }
        });
        let again = again.map(|(route, _)| route);
        let route = [again, kept].into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost));
        let route = route.filter(|route| route.cost < f64::INFINITY);
        let outcome = outcome.get_or_insert_with(|| Outcome {
            travel_sol: None,
            stuck: false,
            expected_sol: route.as_ref().map_or(f64::INFINITY, |route| route.cost),
            route: Vec::new(),
            flight: flight.clone(),
            stages: Vec::new(),
        });
        let Some(route) = route else { break };
        let drive = drive(world.prior.surface(), &world.truth, &route.points, clock.allowance());
        clock.begin_next();
        spent_sol += drive.duration_sol;
        outcome.stages.push(Stage { flight, route: route.points.clone(), end: drive.at });
        outcome.route = route.points;
        match drive.end {
            DriveEnd::Arrived => outcome.travel_sol = Some(spent_sol),
            DriveEnd::Stuck { .. } => outcome.stuck = true,
            DriveEnd::OutOfTime => {
                for cell in drive.sensed {
                    belief.set(cell, SpeedDistribution::certain(world.truth.speeds[cell]));
                }
                trip.start = drive.at;
                let ahead = &outcome.route[drive.reached + 1..];
                let points = std::iter::once(drive.at).chain(ahead.iter().copied()).collect();
                announced = Some(Route::new(&belief.expected_time(Caution::default()), points));
                continue;
            }
        }
        break;
    }
    outcome.expect("at least one stage")
}

/// The safe rover's route before anything was scouted.
#[must_use]
pub fn announce(world: &World, setup: &Setup, seed: u64) -> Option<Route> {
    plan(&world.prior, &world.trip, setup, seed).map(|(route, _)| route)
}

fn flight(
    belief: &Belief,
    trip: &Trip,
    arm: Arm,
    setup: &Setup,
    seed: u64,
    announced: Option<&Route>,
) -> Vec<Point> {
    let view_m = Camera::default().radius_m();
    match (arm, announced) {
        (Arm::ScoutRoute, Some(route)) => scout_route(route, BUDGET_M),
        (Arm::InformationTheoretic, _) => {
            let settings = RrtStarIt { iterations: setup.samples.helicopter, budget_m: BUDGET_M, view_m };
            rrt_star_it(belief, trip.start, &settings, seed)
        }
        (Arm::ScoutValue, _) => scout_value(
            belief,
            trip,
            &ScoutValue { budget_m: BUDGET_M, view_m, ..ScoutValue::default() },
            seed,
        ),
        _ => vec![trip.start],
    }
}

/// What the helicopter sees becomes known.
fn look(belief: &mut Belief, world: &World, flight: &[Point], setup: &Setup) {
    let view_m = Camera::default().radius_m();
    match &setup.sensor {
        None => scout(belief, &world.truth, flight, view_m),
        Some((sensor, seed)) => {
            let readings = scout_world::readings(&world.truth.speeds, sensor, *seed);
            observe(belief, &world.prior, flight, view_m, sensor, &readings);
        }
    }
}

/// The route with the clearance that it keeps.
fn plan(belief: &Belief, trip: &Trip, setup: &Setup, seed: u64) -> Option<(Route, f64)> {
    let costs = belief.expected_time(Caution::default());
    match setup.planner {
        RoverPlanner::RrtStarEtt => {
            rrt_star_ett(&costs, trip, setup.samples.rover, seed).map(|route| (route, 0.0))
        }
        RoverPlanner::EttExact => ett_exact_or_closer(&costs, trip, setup.clearance_m),
    }
}

fn driven(world: &World, route: Option<Route>) -> Outcome {
    let Some(route) = route else {
        return Outcome {
            travel_sol: None,
            stuck: false,
            expected_sol: f64::INFINITY,
            route: Vec::new(),
            flight: Vec::new(),
            stages: Vec::new(),
        };
    };
    let drive = drive(world.prior.surface(), &world.truth, &route.points, Allowance::UNLIMITED);
    let arrived = drive.end == DriveEnd::Arrived;
    Outcome {
        travel_sol: arrived.then_some(drive.duration_sol),
        stuck: !arrived,
        expected_sol: route.cost,
        route: route.points,
        flight: Vec::new(),
        stages: Vec::new(),
    }
}
