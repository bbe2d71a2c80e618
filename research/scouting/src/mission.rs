//! One world, flown and driven in each arm of the study.

use std::sync::Arc;

use helicopter::{BUDGET_M, Camera, scout};
use routing::{
    Route, RrtStarIt, ScoutValue, ett_exact, rrt_star, rrt_star_ett, rrt_star_it, scout_route, scout_value,
};
use rover::{Belief, Caution, DriveEnd, Point, drive};
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
    /// The safe rover that knows the truth: what no helicopter can better.
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
    /// Of the rover's planners.
    pub rover: usize,
    /// Of the helicopter's.
    pub helicopter: usize,
}

impl Samples {
    /// Those for 200 x 200 cells.
    pub const MONTE_CARLO: Self = Self { rover: 1200, helicopter: 600 };
}

/// What became of the rover.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Time to the goal, in Sol; none if the rover is stuck or found no route.
    pub travel_sol: Option<f64>,
    /// Whether it entered a cell of speed 0.
    pub stuck: bool,
    /// Expected time of the route driven, under what was known at the start of the drive; infinite without a route.
    #[serde(skip)]
    pub expected_sol: f64,
    /// The route driven.
    #[serde(skip)]
    pub route: Vec<Point>,
    /// The helicopter's flight; empty without one.
    #[serde(skip)]
    pub flight: Vec<Point>,
}

/// Plans, scouts, plans again and drives: the two stages of the paper, in one arm.
///
/// `announced` is the safe rover's route on the prior, which the arms of one world share; see [`announce`].
#[must_use]
pub fn fly(
    world: &World,
    arm: Arm,
    planner: RoverPlanner,
    samples: Samples,
    seed: u64,
    announced: Option<&Route>,
) -> Outcome {
    if arm == Arm::NaiveRover {
        let route = rrt_star(&world.prior.distance(), &world.trip, samples.rover, seed);
        return driven(world, route, Vec::new());
    }
    if arm == Arm::SafeRover {
        return driven(world, announced.cloned(), Vec::new());
    }
    let view_m = Camera::default().radius_m();
    let start = world.trip.start;
    let flight = match (arm, announced) {
        (Arm::ScoutRoute, Some(route)) => scout_route(route, BUDGET_M),
        (Arm::InformationTheoretic, _) => {
            let settings = RrtStarIt { iterations: samples.helicopter, budget_m: BUDGET_M, view_m };
            rrt_star_it(&world.prior, start, &settings, seed)
        }
        (Arm::ScoutValue, _) => scout_value(
            &world.prior,
            &world.trip,
            &ScoutValue { budget_m: BUDGET_M, view_m, ..ScoutValue::default() },
            seed,
        ),
        _ => vec![start],
    };
    let mut belief = world.prior.clone();
    if arm == Arm::Clairvoyant {
        belief = world.truth.known(Arc::clone(belief.surface())).expect("a speed for each cell");
    } else {
        scout(&mut belief, &world.truth, &flight, view_m);
    }
    let costs = belief.expected_time(Caution::default());
    // Another seed than before: the same samples would give the same tree where nothing is new.
    let again = plan(&belief, world, planner, samples, !seed);
    let kept = announced.map(|route| Route::new(&costs, route.points.clone()));
    let route = [again, kept].into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost));
    driven(world, route.filter(|route| route.cost < f64::INFINITY), flight)
}

/// The safe rover's route before anything was scouted.
#[must_use]
pub fn announce(world: &World, planner: RoverPlanner, samples: Samples, seed: u64) -> Option<Route> {
    plan(&world.prior, world, planner, samples, seed)
}

fn plan(belief: &Belief, world: &World, planner: RoverPlanner, samples: Samples, seed: u64) -> Option<Route> {
    let costs = belief.expected_time(Caution::default());
    match planner {
        RoverPlanner::RrtStarEtt => rrt_star_ett(&costs, &world.trip, samples.rover, seed),
        RoverPlanner::EttExact => ett_exact(&costs, &world.trip),
    }
}

fn driven(world: &World, route: Option<Route>, flight: Vec<Point>) -> Outcome {
    let Some(route) = route else {
        return Outcome {
            travel_sol: None,
            stuck: false,
            expected_sol: f64::INFINITY,
            route: Vec::new(),
            flight,
        };
    };
    let drive = drive(world.prior.surface(), &world.truth, &route.points, f64::INFINITY);
    let arrived = drive.end == DriveEnd::Arrived;
    Outcome {
        travel_sol: arrived.then_some(drive.duration_sol),
        stuck: !arrived,
        expected_sol: route.cost,
        route: route.points,
        flight,
    }
}
