//! Planners for a helicopter that looks ahead for a rover; [`LookAhead`] does so for a hopper.
//!
//! It announces a flight, flies it point by point, and is done; if the mission has further stages it waits for the next, which finds
//! it with the rover, without a route and with its whole budget. A flight that was announced is flown to its end whoever
//! plans, so what is seen on the way changes nothing of it.

pub mod ahead;

use contract::{Action, Member, Name, RobotId, Route, Standing, Task, Team, Vehicle};
use routing::{Goal, RrtStarIt, ScoutValue, Trip, rrt_star_it, scout_route, scout_value};
use rover::Point;

use crate::names;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};
use crate::uncertain::{Turn, announcement, point};

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
                let rest = ward(turn.team, is_driver).and_then(|(_, driver)| turn.rest_of(driver));
                let along = |mut points: Vec<Point>| {
                    // A rover that waits for nobody may have driven on.
                    points[0] = start;
                    scout_route(&routing::Route { points, cost: 0.0 }, budget_m)
                };
                rest.map_or(vec![start], along)
            }
            FlightSearch::Spread => {
                let iterations = turn.scout.helicopter_samples as usize;
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
        let driver = ward(turn.team, is_driver).map(|(_, driver)| driver);
        let is_first = driver.is_some_and(|driver| driver.last.is_none());
        if self.search == FlightSearch::Route && is_first {
            return idle(turn.wait_or_hold());
        }
        let (Vehicle::Helicopter { budget_m, .. }, Some(view_m)) =
            (turn.me.robot.vehicle, turn.me.robot.sensor.view_m())
        else {
            return idle(Action::Hold);
        };
        // Several helicopters with the same random numbers would fly side by side.
        let before = turn.team.members.iter().take(turn.team.due.0.into());
        let number =
            before.filter(|member| matches!(member.robot.vehicle, Vehicle::Helicopter { .. })).count();
        let seed = turn.seed().wrapping_add(number as u64);
        let flight = Flight { budget_m: budget_m - turn.travel.flown_m, view_m, trip, seed };
        let route = self.flight(turn, &flight).as_deref().and_then(announcement);
        let Some(route) = route else { return idle(Action::Done) };
        let plan = Plan::at_once(Action::Announce(route.id()), PlanStatus::Solved);
        self.announced = Some(route);
        plan
    }
}

/// The robot that the helicopter which decides looks ahead for, among those that `wants` names and that still act: the first
/// helicopter for the first of them, the second for the second, and from the last on again for the first.
fn ward(team: &Team, wants: impl Fn(&Vehicle) -> bool) -> Option<(RobotId, &Member)> {
    let wards = || {
        let acts = |(_, member): &(RobotId, &Member)| {
            member.standing == Standing::Active && wants(&member.robot.vehicle)
        };
        (0..).map(RobotId).zip(team.members.iter()).filter(acts)
    };
    let before = team.members.iter().take(team.due.0.into());
    let number = before.filter(|member| matches!(member.robot.vehicle, Vehicle::Helicopter { .. })).count();
    wards().nth(number % wards().count().max(1))
}

fn is_driver(vehicle: &Vehicle) -> bool {
    matches!(vehicle, Vehicle::Driver { .. })
}

impl Planner for Fly {
    fn name(&self) -> Name {
        names::name(match self.search {
            FlightSearch::Route => names::SCOUT_ROUTE,
            FlightSearch::Spread => names::RRT_STAR_IT,
            FlightSearch::Value => names::SCOUT_VALUE,
        })
    }

    fn suits(&self, task: Task) -> bool {
        matches!(task, Task::Scout(_))
    }

    fn announces(&self) -> bool {
        true
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let hold = Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        let Some(turn) = Turn::of(situation) else { return hold };
        if !matches!(turn.me.robot.vehicle, Vehicle::Helicopter { .. }) {
            return hold;
        }
        let driver = ward(turn.team, is_driver).map(|(_, driver)| driver);
        let trip = match driver.map(|driver| (driver.robot.vehicle, driver.travel)) {
            Some((Vehicle::Driver { goal, goal_radius_m, .. }, Some(travel))) => {
                Trip { start: point(travel.at), goal: Goal { at: point(goal), radius_m: goal_radius_m } }
            }
            _ => return Plan::at_once(Action::Done, PlanStatus::Solved),
        };
        if turn.travel.route.is_none() {
            self.begin(&turn, trip)
        } else if turn.travel.is_under_way() {
            Plan::at_once(Action::Fly, PlanStatus::Solved)
        } else if turn.stage() < turn.scout.stages {
            Plan::at_once(turn.wait_or_hold(), PlanStatus::Solved)
        } else {
            Plan::at_once(Action::Done, PlanStatus::Solved)
        }
    }

    fn announced(&self) -> Option<&Route> {
        self.announced.as_ref()
    }
}
