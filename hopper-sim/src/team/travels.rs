//! Robots that announce routes and go from point to point: how far each is, and what its planner has proposed.

use std::collections::VecDeque;

use contract::{
    Action, Announcement, Body, Branch, Brief, Cell, Decision, Flight, Helicopter, Outcome, Placement,
    Refusal, RobotId, Route, RouteId, Routes, Standing, Travel, Waypoint,
};

use super::roster::{Act, Roster, Turn};
use super::turn_order::duration_ns;

/// Proposed routes that are kept for each robot until a command announces one of them.
const OFFERS_MAX: usize = 4;

/// How far a flight may be beyond its budget, metres: the sum of its legs is rounded.
const BUDGET_TOLERANCE_M: f64 = 1e-6;

/// How far the first point of a route may be from where the robot stands, metres.
pub const START_TOLERANCE_M: f64 = 1e-6;

/// The routes of a mission, and where robots are on them.
#[derive(Clone, Debug)]
pub struct Travels {
    /// Where each robot is on its route, in the order of their numbers; `None` for one that goes
    /// from cell to cell.
    travels: Vec<Option<Travel>>,
    /// All routes that were announced.
    routes: Routes,
    /// Routes received from planners that no command has named yet, by the robots' numbers.
    offers: Vec<VecDeque<Route>>,
}

/// What an action of a robot that goes from point to point comes to.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    pub outcome: Outcome,
    /// Where the robot is afterwards.
    pub at: Waypoint,
}

impl Arrival {
    /// It stays at `at`, in cell `from`, for that time.
    #[must_use]
    pub fn stays(from: Cell, at: Waypoint, branch: Branch, seconds: f64) -> Self {
        let flight = Flight { flight_time_s: seconds, flights: 1, ..Flight::default() };
        Self { outcome: Outcome { branch, from, to: from, flight }, at }
    }

    /// It goes `range_m` metres from cell `from` to `at`, in cell `to`.
    #[must_use]
    pub fn goes([from, to]: [Cell; 2], at: Waypoint, branch: Branch, range_m: f64, seconds: f64) -> Self {
        let flight = Flight { range_m, flight_time_s: seconds, flights: 1, ..Flight::default() };
        Self { outcome: Outcome { branch, from, to, flight }, at }
    }

    fn is_stranded(&self) -> bool {
        self.outcome.branch == Branch::Stranded
    }
}

impl Travels {
    /// Before the first action.
    #[must_use]
    pub fn new(brief: &Brief) -> Self {
        let travels = brief.robots.iter().map(|robot| {
            let has_routes = robot.body.along_route().is_some();
            has_routes.then(|| Travel::from_start(robot.start_at))
        });
        let travels: Vec<Option<Travel>> = travels.collect();
        Self { offers: vec![VecDeque::new(); travels.len()], travels, routes: Routes::default() }
    }

    /// How far `robot` is, if it goes from point to point.
    #[must_use]
    pub fn get(&self, robot: RobotId) -> Option<Travel> {
        self.travels.get(usize::from(robot.0)).copied().flatten()
    }

    /// The route with that fingerprint, if it was announced.
    #[must_use]
    pub fn route(&self, id: RouteId) -> Option<&Route> {
        self.routes.get(id)
    }

    /// All routes that were announced.
    pub fn routes(&self) -> impl Iterator<Item = &Route> {
        self.routes.iter()
    }

    /// Adds a route of an earlier life.
    pub fn recall_route(&mut self, route: Route) {
        self.routes.insert(route);
    }

    /// Keeps the points of a route until a command announces it.
    ///
    /// # Errors
    /// If the mission has no such robot.
    pub fn offer(&mut self, announcement: Announcement) -> Result<(), Refusal> {
        let Announcement { robot, route, .. } = announcement;
        let robots = self.travels.len() as u16;
        let unknown = Refusal::WrongRobot { robots, got: robot.0.into() };
        let offers = self.offers.get_mut(usize::from(robot.0)).ok_or(unknown)?;
        if !offers.contains(&route) {
            offers.truncate(OFFERS_MAX - 1);
            offers.push_front(route);
        }
        Ok(())
    }

    /// The point that a robot goes to next on its route.
    #[must_use]
    pub fn next(&self, travel: Travel) -> Option<Waypoint> {
        let Travel { route, reached, .. } = travel;
        self.routes.get(route?)?.waypoints().get(reached as usize + 1).copied()
    }

    /// Why `robot` shall not announce the route, if there is a reason; `is_on_map` tells of a point whether it is one of the
    /// map.
    #[must_use]
    pub fn refusal_of_route(
        &self,
        body: Body,
        robot: RobotId,
        id: RouteId,
        is_on_map: impl Fn(Waypoint) -> bool,
    ) -> Option<Refusal> {
        let travel = self.get(robot)?;
        let Some(route) = self.offered(robot, id) else { return Some(Refusal::UnknownRoute { route: id }) };
        if let Some(outside) = route.waypoints().iter().find(|at| !is_on_map(**at)) {
            return Some(Refusal::malformed("route.waypoints", "points on the map", outside));
        }
        let begins_m = route.waypoints()[0].distance_m(travel.at);
        if begins_m > START_TOLERANCE_M {
            let need = format!("to begin where the robot is, at {}", travel.at);
            return Some(Refusal::malformed("route.waypoints", &need, route.waypoints()[0]));
        }
        beyond_budget(body, travel, route.length_m())
    }

    /// Why a helicopter shall not execute `action` but announce a route, if there is a reason.
    #[must_use]
    pub fn refusal_of_flight(&self, body: Body, robot: RobotId, action: Action) -> Option<Refusal> {
        let needs = |need: &str| Some(Refusal::malformed("command.action", need, action));
        let travel = self.get(robot)?;
        match (action, self.next(travel)) {
            (Action::Hold | Action::Wait | Action::Done, _) => None,
            (Action::Fly, Some(to)) => beyond_budget(body, travel, travel.at.distance_m(to)),
            (Action::Fly, None) => needs("an announced route with a point to go to"),
            _ => needs("fly, announce, wait, done or hold: the robot is a helicopter"),
        }
    }

    /// A route received from the planner of `robot`, or one that was announced before.
    fn offered(&self, robot: RobotId, id: RouteId) -> Option<&Route> {
        let offers = &self.offers[usize::from(robot.0)];
        offers.iter().find(|route| route.id() == id).or_else(|| self.routes.get(id))
    }

    /// Keeps the route that `robot` announces with `action`, if it announces one.
    pub fn keep_announced(&mut self, robot: RobotId, action: Action) {
        if let Action::Announce(id) = action
            && let Some(route) = self.offered(robot, id).cloned()
        {
            self.routes.insert(route);
            self.offers[usize::from(robot.0)].clear();
        }
    }

    /// What `action` of `robot` comes to, if it is no drive: a flight takes its length divided by the speed, to announce and to
    /// hold take a second, to wait and to be done no time. `cell_of` is the cell of a point.
    ///
    /// # Panics
    /// If the robot goes from cell to cell.
    #[must_use]
    pub fn flight(
        &self,
        roster: &Roster,
        robot: RobotId,
        action: Action,
        cell_of: impl Fn(Waypoint) -> Cell,
    ) -> Arrival {
        let travel = self.get(robot).expect("a robot that goes from point to point");
        let entry = roster.entry(robot);
        let (from, here) = (entry.at.cell, travel.at);
        if roster.fails_now(robot) {
            return Arrival::stays(from, here, Branch::Stranded, 1.0);
        }
        match (action, self.next(travel), entry.robot.body) {
            (Action::Fly, Some(to), Body::Helicopter(Helicopter { speed_mps, .. })) => {
                let range_m = here.distance_m(to);
                Arrival::goes([from, cell_of(to)], to, Branch::Intended, range_m, range_m / speed_mps)
            }
            (Action::Wait | Action::Done, ..) => Arrival::stays(from, here, Branch::Held, 0.0),
            _ => Arrival::stays(from, here, Branch::Held, 1.0),
        }
    }

    /// Takes note that an action of the robot that is due has come to `arrival`.
    ///
    /// # Panics
    /// If another robot is due.
    pub fn settle(&mut self, roster: &mut Roster, act: &Act, arrival: &Arrival) {
        let Act { robot, decision, action, .. } = *act;
        let Arrival { outcome, at } = *arrival;
        let is_stranded = arrival.is_stranded();
        let turn = match action {
            Action::Wait if !is_stranded => Turn::Waits,
            Action::Done if !is_stranded => Turn::Ends,
            _ => Turn::Lasts(duration_ns(outcome.flight.flight_time_s)),
        };
        roster.act(act, turn);
        if is_stranded {
            roster.end(robot, Standing::Stranded);
        }
        let placement = Placement { cell: outcome.to, ..roster.entry(robot).at };
        roster.place(robot, placement);
        let action = if is_stranded { Action::Hold } else { action };
        self.take(robot, decision, action, at, outcome.flight.range_m);
        if let (Branch::Halted, Some(travel)) = (outcome.branch, self.get_mut(robot)) {
            // It is still on its way to the point.
            travel.reached -= 1;
            (travel.halts, travel.halted) = (travel.halts + 1, Some(decision));
        }
    }

    /// A stage of `rover` is over: the helicopters that still act are where it is from then on, without a route and with their
    /// whole budget.
    pub fn rejoin(&mut self, roster: &mut Roster, rover: RobotId) {
        let Some(travel) = self.get(rover) else { return };
        let (cell, now_ns) = (roster.entry(rover).at.cell, roster.ready_at_ns(rover));
        let helicopters: Vec<RobotId> = roster
            .entries()
            .filter(|(_, entry)| {
                entry.standing == Standing::Active && matches!(entry.robot.body, Body::Helicopter(_))
            })
            .map(|(robot, _)| robot)
            .collect();
        for robot in helicopters {
            roster.place(robot, Placement { cell, ..roster.entry(robot).at });
            roster.put_off(robot, now_ns);
            if let Some(of) = self.get_mut(robot) {
                *of = Travel { moved: of.moved, ..Travel::from_start(travel.at) };
            }
        }
    }

    fn get_mut(&mut self, robot: RobotId) -> Option<&mut Travel> {
        self.travels.get_mut(usize::from(robot.0)).and_then(Option::as_mut)
    }

    fn take(&mut self, robot: RobotId, decision: Decision, action: Action, at: Waypoint, range_m: f64) {
        let legs = |id| self.routes.get(id).map(|route| route.waypoints().len() as u32 - 1);
        let legs = if let Action::Announce(id) = action { legs(id) } else { None };
        let Some(travel) = self.get_mut(robot) else { return };
        match action {
            Action::Announce(id) => {
                (travel.route, travel.announced) = (Some(id), Some(decision));
                (travel.reached, travel.legs) = (0, legs.unwrap_or_default());
            }
            Action::Drive | Action::Fly if travel.is_under_way() => {
                travel.reached += 1;
                travel.moved = Some(decision);
                if action == Action::Fly {
                    travel.flown_m += range_m;
                }
            }
            _ => {}
        }
        travel.at = at;
    }
}

/// Why a helicopter shall not fly `length_m` more metres, if there is a reason.
fn beyond_budget(body: Body, travel: Travel, length_m: f64) -> Option<Refusal> {
    let Body::Helicopter(Helicopter { budget_m, .. }) = body else { return None };
    let need = budget_m - travel.flown_m;
    (length_m > need + BUDGET_TOLERANCE_M).then_some(Refusal::BeyondBudget { need, got: length_m })
}
