//! Planners for a helicopter that looks ahead for a rover; [`LookAhead`] does so for a hopper.
//!
//! It announces a flight, flies it point by point, and is done; if the mission has further stages it waits for the next, which finds
//! it with the rover, without a route and with its whole budget. A flight that was announced is flown to its end whoever
//! plans, so what is seen on the way changes nothing of it.

pub mod ahead;

use contract::{Action, Body, Brief, Goal, Member, Name, Robot, RobotId, Route, Standing, Team};
use routing::{RrtStarIt, ScoutValue, Trip, rrt_star_it, scout_route, scout_value};
use rover::Point;

use crate::names;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};
use crate::uncertain::{Turn, announcement, point, trip};

pub use ahead::LookAhead;

/// How a flight is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlightSearch {
    /// `scout_route`: along what is left of the rover's announced route.
    Route,
    /// `rrt_star_it`: where speeds are spread most.
    Spread,
    /// `scout_value`: where knowing helps the rover most.
    Value,
}

/// A planner for the helicopter.
#[derive(Debug)]
pub struct Fly {
    search: FlightSearch,
    /// The flight of the last plan that announces one: what is to be sent with the command.
    announced: Option<Route>,
}

/// What a flight is planned from.
struct Flight {
    budget_m: f64,
    view_m: f64,
    /// The rover's trip from where it is.
    trip: Trip,
    seed: u64,
}

impl Fly {
    /// A planner that has planned nothing.
    #[must_use]
    pub fn new(search: FlightSearch) -> Self {
        Self { search, announced: None }
    }

    /// The points of a flight from where the helicopter is; that point alone if there is nothing to fly for.
    fn flight(&self, turn: &Turn<'_>, flight: &Flight) -> Option<Vec<Point>> {
        let start = point(turn.travel.at);
        let Flight { budget_m, view_m, trip, seed } = *flight;
        Some(match self.search {
            FlightSearch::Route => {
                let rest = driver(turn).and_then(|(_, driver)| turn.rest_of(driver));
                let along = |mut points: Vec<Point>| {
                    // A rover that waits for nobody may have driven on.
                    points[0] = start;
                    scout_route(&routing::Route { points, cost: 0.0 }, budget_m)
                };
                rest.map_or(vec![start], along)
            }
            FlightSearch::Spread => {
                let iterations = turn.sampling.helicopter_samples as usize;
                rrt_star_it(&turn.belief()?, start, &RrtStarIt { iterations, budget_m, view_m }, seed)
            }
            FlightSearch::Value => {
                let settings = ScoutValue { from: Some(start), budget_m, view_m, ..ScoutValue::default() };
                scout_value(&turn.belief()?, &trip, &settings, seed)
            }
        })
    }

    /// What to do before a flight is announced.
    fn begin(&mut self, turn: &Turn<'_>, trip: Trip) -> Plan {
        let idle = |action| Plan::at_once(action, PlanStatus::Infeasible);
        let is_first = driver(turn).is_some_and(|(_, driver)| driver.last.is_none());
        if self.search == FlightSearch::Route && is_first {
            return idle(turn.wait_or_hold());
        }
        let (Body::Helicopter(helicopter), Some(view_m)) = (turn.robot.body, turn.robot.sensor.view_m())
        else {
            return idle(Action::Hold);
        };
        // Several helicopters with the same random numbers would fly side by side.
        let seed = turn.seed().wrapping_add(helicopters_before(turn.brief, turn.team.due) as u64);
        let budget_m = helicopter.budget_m - turn.travel.flown_m;
        let flight = Flight { budget_m, view_m, trip, seed };
        let route = self.flight(turn, &flight).as_deref().and_then(announcement);
        let Some(route) = route else { return idle(Action::Done) };
        let plan = Plan::at_once(Action::Announce(route.id()), PlanStatus::Solved);
        self.announced = Some(route);
        plan
    }
}

/// The robot that the helicopter that decides looks ahead for, among those that still act and whose body it `wants`: the first
/// helicopter for the first of them, the second for the second, and from the last on again for the first.
fn ward<'a>(brief: &Brief, team: &'a Team, wants: impl Fn(&Body) -> bool) -> Option<(RobotId, &'a Member)> {
    let wards = || {
        let numbered = brief.robots.numbered().zip(team.members.iter());
        let acting = numbered.filter(|(_, member)| member.standing == Standing::Active);
        acting.filter(|((_, robot), _)| wants(&robot.body)).map(|((number, _), member)| (number, member))
    };
    wards().nth(helicopters_before(brief, team.due) % wards().count().max(1))
}

/// The rover that the helicopter that decides looks ahead for.
fn driver<'a>(turn: &Turn<'a>) -> Option<(RobotId, &'a Member)> {
    ward(turn.brief, turn.team, |body| body.drives())
}

/// How many of the robots with smaller numbers are helicopters.
fn helicopters_before(brief: &Brief, robot: RobotId) -> usize {
    let before = brief.robots.iter().take(robot.0.into());
    before.filter(|other| matches!(other.body, Body::Helicopter(_))).count()
}

impl Planner for Fly {
    fn name(&self) -> Name {
        names::name(match self.search {
            FlightSearch::Route => names::SCOUT_ROUTE,
            FlightSearch::Spread => names::RRT_STAR_IT,
            FlightSearch::Value => names::SCOUT_VALUE,
        })
    }

    fn suits(&self, robot: &Robot) -> bool {
        matches!(robot.body, Body::Helicopter(_))
    }

    fn announces(&self) -> bool {
        true
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let hold = Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        let Some(turn) = Turn::of(situation) else { return hold };
        if !matches!(turn.robot.body, Body::Helicopter(_)) {
            return hold;
        }
        let driver = driver(&turn);
        let goal = driver.and_then(|(number, _)| Some(turn.brief.robots.at(number)?.goal));
        let travel = driver.and_then(|(_, member)| member.travel);
        let (Some(Goal::Reach(goal)), Some(travel)) = (goal, travel) else {
            return Plan::at_once(Action::Done, PlanStatus::Solved);
        };
        let trip = trip(&travel, &goal);
        if turn.travel.route.is_none() {
            self.begin(&turn, trip)
        } else if turn.travel.is_under_way() {
            Plan::at_once(Action::Fly, PlanStatus::Solved)
        } else if turn.stage() < turn.sampling.stages {
            Plan::at_once(turn.wait_or_hold(), PlanStatus::Solved)
        } else {
            Plan::at_once(Action::Done, PlanStatus::Solved)
        }
    }

    fn announced(&self) -> Option<&Route> {
        self.announced.as_ref()
    }
}
