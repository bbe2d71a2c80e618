//! Planners for a rover that drives to a goal over ground of uncertain speed.
//!
//! As in Folsom et al. 2021 the rover announces a route and waits; once all flights are flown it plans again, keeps the cheaper of
//! the old route and the new one under what is known then, drives, and stays on it. If hopper-sim ends the drive because
//! the time of the stage is used up, what is left of the route takes the place of the old one: the rover waits, plans again
//! and drives on. What comes next follows from the team alone: from what has halted the rover, and who has moved since its route
//! was announced. So a planner that was restarted, or takes over from another, goes on where the one before it was.
//!
//! Routes lead around robots that act no more and around the goals of hoppers, or over them where there is no other way. If the
//! next point of the route is taken when its turn comes, the rover announces another route, or waits; it gives up if a robot
//! that has stopped for good is there and no other route leads past it.

use contract::{Account, Action, Goal, Name, Profile, Robot, Route, Standing, Travel, Waypoint};
use routing::{KeptClear, Trip, ett_exact_or_closer, rrt_star, rrt_star_ett};
use rover::{Belief, Caution, Point};

use crate::names;
use crate::others::occupant;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};
use crate::uncertain::{Around, Turn, announcement, trip};

/// How far `ett_exact` keeps from forbidden cells in profile `hopper`, metres: half a cell. In the paper's it keeps no distance.
///
/// A route without goes along the edges of forbidden cells, so that the least error on the way leads onto them.
pub const CLEARANCE_M: f64 = 0.5;

/// How a rover's route is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RouteSearch {
    /// `rrt_star`: the shortest route, whatever the risk. It waits for nobody and is never planned again.
    Shortest,
    /// `rrt_star_ett`: least expected travel time over safe ground.
    ExpectedTime,
    /// `ett_exact`: the same, searched completely; in profile `hopper` at [`CLEARANCE_M`] from forbidden cells where there is such a
    /// route.
    Exact,
}

/// A planner for the rover.
#[derive(Debug)]
pub struct Drive {
    search: RouteSearch,
    /// The route of the last plan that announces one: what is to be sent with the command.
    announced: Option<Route>,
}

impl Drive {
    /// A planner that has planned nothing.
    #[must_use]
    pub fn new(search: RouteSearch) -> Self {
        Self { search, announced: None }
    }

    /// A route on what is known, with random numbers of `seed`, and how far it keeps from forbidden cells.
    fn route(
        &self,
        turn: &Turn<'_>,
        belief: &Belief,
        trip: &Trip,
        seed: u64,
    ) -> Option<(routing::Route, f64)> {
        let samples = turn.sampling.rover_samples as usize;
        let costs = || belief.expected_time(Caution::default());
        let route = match self.search {
            RouteSearch::Shortest => rrt_star(&belief.distance(), trip, samples, seed),
            RouteSearch::ExpectedTime => rrt_star_ett(&costs(), trip, samples, seed),
            RouteSearch::Exact => {
                let clearance_m = match turn.brief.profile {
                    Profile::Paper2023 | Profile::Paper2022 => 0.0,
                    Profile::Hopper => CLEARANCE_M,
                };
                return ett_exact_or_closer(&costs(), trip, clearance_m);
            }
        };
        route.map(|route| (route, 0.0))
    }

    fn announce(&mut self, route: &routing::Route) -> Plan {
        let Some(route) = announcement(&route.points) else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        let plan = Plan::at_once(Action::Announce(route.id()), PlanStatus::Solved);
        self.announced = Some(route);
        plan
    }

    /// What to do before the first drive of a stage.
    fn begin(&mut self, turn: &Turn<'_>, trip: &Trip) -> Plan {
        let idle = |action| Plan::at_once(action, PlanStatus::Infeasible);
        let replans = self.search != RouteSearch::Shortest;
        let waits_for_scouts = turn.is_scouted() && replans;
        let old = turn.rest_of(turn.me);
        if old.is_some() && waits_for_scouts {
            return Plan::at_once(turn.wait_or_hold(), PlanStatus::Solved);
        }
        let Travel { announced, halted, .. } = turn.travel;
        // Its own drive in the stage before counts too.
        let news = turn.others().filter_map(|(_, other)| other.travel?.moved).chain(halted).max();
        let is_news = news.is_some() && news >= announced && replans;
        if old.is_some() && !is_news {
            return Plan::at_once(Action::Drive, PlanStatus::Solved);
        }
        // Another seed than before: the same samples would give the same tree where nothing is new.
        let seed = if is_news { !turn.seed() } else { turn.seed() };
        let around_others = turn.belief_around(Around::Stopped);
        let Some(belief) = around_others else { return idle(Action::Hold) };
        if let Some(plan) = self.cheapest(turn, &belief, trip, seed, old.as_ref()) {
            return plan;
        }
        // Who finds no way around others drives past them.
        let past_others = if turn.is_alone() { None } else { turn.belief_around(Around::Goals) };
        let plan = past_others.and_then(|belief| self.cheapest(turn, &belief, trip, seed, old.as_ref()));
        plan.unwrap_or_else(|| idle(if waits_for_scouts { turn.wait_or_hold() } else { Action::Done }))
    }

    /// To announce a new route, or to drive on along the `old` one if that is no dearer; `None` if there is no way.
    fn cheapest(
        &mut self,
        turn: &Turn<'_>,
        belief: &Belief,
        trip: &Trip,
        seed: u64,
        old: Option<&Vec<Point>>,
    ) -> Option<Plan> {
        let again = self.route(turn, belief, trip, seed);
        let Some(old) = old else { return again.map(|(route, _)| self.announce(&route)) };
        let costs = belief.expected_time(Caution::default());
        // What was seen since it was planned may lie close to the old route.
        let clearance_m = again.as_ref().map_or(0.0, |(_, clearance_m)| *clearance_m);
        let again = again.map(|(route, _)| route);
        let cost = KeptClear::new(&costs, trip, clearance_m).way(old);
        let kept = routing::Route { points: old.clone(), cost };
        let cheapest = again.filter(|again| again.cost <= kept.cost).unwrap_or_else(|| kept.clone());
        if cheapest.cost == f64::INFINITY {
            None
        } else if announcement(&cheapest.points) == announcement(&kept.points) {
            Some(Plan::at_once(Action::Drive, PlanStatus::Solved))
        } else {
            Some(self.announce(&cheapest))
        }
    }
}

impl Drive {
    /// To drive on, which is `plan`; or around a robot that stands where the rover would drive to: for good, or so that the drive
    /// has been refused.
    fn pass_by(&mut self, turn: &Turn<'_>, trip: &Trip, situation: &Situation<'_>, plan: Plan) -> Plan {
        let grid = &turn.map.grid;
        let next = turn.rest_of(turn.me).and_then(|rest| rest.get(1).copied());
        let to = next.map(|at| Waypoint { x_m: at.x_m, y_m: at.y_m }.cell_of(grid));
        let Some(other) = to.and_then(|to| occupant(turn.brief, turn.team, to)) else {
            return plan;
        };
        let is_gone_soon = other.standing == Standing::Active;
        if is_gone_soon && !situation.state.vetoed.has(Action::Drive) {
            return plan;
        }
        let around = turn.belief_around(Around::All);
        let around = around.and_then(|belief| self.route(turn, &belief, trip, !turn.seed()));
        let mut around = around.map(|(route, _)| route);
        // A route along the edge of a cell may have a point that counts as one of the cell. A way around that begins with such a
        // point would be announced again and again.
        if around.as_ref().is_some_and(|route| begins_where_another_is(turn, route)) {
            around = None;
        }
        match around.or_else(|| rest_without_taken_points(turn)) {
            Some(route) => self.announce(&route),
            None if is_gone_soon => Plan::at_once(turn.wait_or_hold(), PlanStatus::Infeasible),
            None => Plan::at_once(Action::Done, PlanStatus::Infeasible),
        }
    }
}

/// Whether another robot is where the first leg of `route` ends.
fn begins_where_another_is(turn: &Turn<'_>, route: &routing::Route) -> bool {
    let grid = &turn.map.grid;
    let next = route.points.get(1).map(|at| Waypoint { x_m: at.x_m, y_m: at.y_m }.cell_of(grid));
    next.is_some_and(|cell| occupant(turn.brief, turn.team, cell).is_some())
}

/// What is left of the route without the points where other robots are, if that is safe to drive.
fn rest_without_taken_points(turn: &Turn<'_>) -> Option<routing::Route> {
    let grid = &turn.map.grid;
    let mut rest = turn.rest_of(turn.me)?;
    let (start, end) = (*rest.first()?, *rest.last()?);
    let is_free = |at: &Point| {
        let cell = Waypoint { x_m: at.x_m, y_m: at.y_m }.cell_of(grid);
        occupant(turn.brief, turn.team, cell).is_none()
    };
    rest.retain(|at| *at == start || is_free(at));
    if rest.last() != Some(&end) {
        return None;
    }
    let route = routing::Route::new(&turn.belief()?.expected_time(Caution::default()), rest);
    route.cost.is_finite().then_some(route)
}

impl Planner for Drive {
    fn name(&self) -> Name {
        names::name(match self.search {
            RouteSearch::Shortest => names::RRT_STAR,
            RouteSearch::ExpectedTime => names::RRT_STAR_ETT,
            RouteSearch::Exact => names::ETT_EXACT,
        })
    }

    fn suits(&self, robot: &Robot) -> bool {
        robot.body.drives()
    }

    fn announces(&self) -> bool {
        true
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let hold = Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        let Some(turn) = Turn::of(situation) else { return hold };
        let Goal::Reach(goal) = turn.robot.goal else { return hold };
        if !turn.robot.body.drives() {
            return hold;
        }
        let trip = trip(&turn.travel, &goal);
        let plan = if turn.travel.reached == 0 || turn.travel.is_stage_fresh() {
            self.begin(&turn, &trip)
        } else if turn.travel.is_under_way() {
            Plan::at_once(Action::Drive, PlanStatus::Solved)
        } else {
            // The route has ended elsewhere than at the goal.
            Plan::at_once(Action::Done, PlanStatus::Infeasible)
        };
        let plan =
            if plan.action == Action::Drive { self.pass_by(&turn, &trip, situation, plan) } else { plan };
        // The guard knows no more than the planner, but may be stricter. What it vetoed of the planner before this one
        // is no reason not to announce a route. Where waiting is no step, others may be gone by then.
        let stays = match situation.brief.account {
            Account::ActionsWithoutWaits => turn.wait_or_hold(),
            Account::Actions | Account::Hopper => Action::Hold,
        };
        if situation.state.vetoed.has(plan.action) { Plan { action: stays, ..hold } } else { plan }
    }

    fn announced(&self) -> Option<&Route> {
        self.announced.as_ref()
    }
}
