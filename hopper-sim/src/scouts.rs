//! Executes the actions of robots that go from point to point: a rover on ground of uncertain speed, and helicopters that
//! look ahead for it.
//!
//! A robot announces a route, and then drives or flies to its points one after the other. A drive takes what the true
//! speeds make of it and ends at the border of a cell of speed 0, where the rover is stranded for good; a flight takes its
//! length divided by the helicopter's speed. To announce and to hold take a second; to wait and to be done take no time.
//!
//! The guard asks for the kind of the action, the length of the route, the flight budget, and the largest probability of
//! getting stuck along a drive as far as anybody can know it: by the prior, or by what the sensors have shown of a cell.

use std::collections::VecDeque;
use std::ops::ControlFlow;

use contract::{
    Action, Announcement, Branch, Brief, Cell, Collected, Decision, DriveSpeed, Flight, Grid, Leader, Member,
    Outcome, Placement, Pose, Record, Refusal, Robot, RobotId, Route, RouteId, Routes, SpeedPrior, Standing,
    State, Status, Team, Travel, Vehicle, Waypoint,
};
use rover::{DriveEnd, Point, SOL_HOURS, Segment, Speed, traverse};
use scenario::Fleet;
use scout_world::TrueGround;
use terrain::Terrain;

use crate::dynamics::Execution;
use crate::guard::Fallback;
use crate::turn_order::{Due, TurnOrder, duration_ns};

/// Announced routes that are kept for each robot until a command names one of them.
const OFFERS_MAX: usize = 4;

/// How far a flight may be beyond its budget, metres: the sum of its legs is rounded.
const BUDGET_TOLERANCE_M: f64 = 1e-6;

/// How far the first point of a route may be from where the robot stands, metres.
const START_TOLERANCE_M: f64 = 1e-6;

/// Where the robots of a mission stand, and which routes they have announced.
#[derive(Clone, Debug)]
pub struct Scouts {
    order: TurnOrder,
    /// In the order of their numbers.
    states: Vec<ScoutState>,
    grid: Grid,
    ground: TrueGround,
    prior: Vec<SpeedPrior>,
    /// Which cells a sensor has shown, in index order.
    seen: Vec<bool>,
    /// All routes that were announced.
    routes: Routes,
    /// What planners told that no command has named yet.
    offers: Vec<VecDeque<Route>>,
    hazard_max: f64,
    /// Actions of a robot after which the mission is a deadlock.
    actions_max: u64,
    /// The robot that acted last.
    actor: Option<RobotId>,
}

/// One robot.
#[derive(Clone, Copy, Debug)]
struct ScoutState {
    robot: Robot,
    at: Placement,
    travel: Travel,
    standing: Standing,
    leader: Leader,
    last: Option<Decision>,
    actions: u64,
    /// The number of the action, from 1, at which it fails.
    fails_at: Option<u64>,
}

/// What an action comes to.
struct Effect {
    outcome: Outcome,
    /// Where the robot is afterwards.
    at: Waypoint,
}

impl Scouts {
    /// The robots before their first action.
    ///
    /// # Panics
    /// If the terrain has no speeds, or a robot goes from cell to cell; scenarios are checked.
    #[must_use]
    pub fn new(brief: &Brief, terrain: &Terrain, fleet: &Fleet) -> Self {
        let state = |(number, robot): (u16, &Robot)| ScoutState {
            robot: *robot,
            at: robot.start,
            travel: Travel::from_start(robot.vehicle.start().expect("a scenario with scouts has starts")),
            standing: Standing::Active,
            leader: Leader::default(),
            last: None,
            actions: 0,
            fails_at: fleet
                .faults
                .iter()
                .find(|fault| fault.robot == RobotId(number))
                .map(|fault| fault.action),
        };
        let states: Vec<ScoutState> = (0..).zip(&fleet.robots).map(state).collect();
        assert_eq!(terrain.prior.len(), terrain.cells.len(), "uncertain ground has a prior for each cell");
        let ground =
            TrueGround::new(brief.grid, &terrain.cells).expect("a grid is within the limits of a lattice");
        let mut routes = Routes::default();
        routes.begin(brief.run);
        let mut scouts = Self {
            order: TurnOrder::new(states.len() as u16),
            grid: brief.grid,
            ground,
            prior: terrain.prior.clone(),
            seen: vec![false; brief.grid.cells()],
            routes,
            offers: vec![VecDeque::new(); states.len()],
            hazard_max: brief.guard.hazard_max,
            actions_max: brief.limits.steps_max,
            actor: None,
            states,
        };
        for state in scouts.states.clone() {
            if let Vehicle::Driver { start, .. } = state.robot.vehicle {
                scouts.see(&state.robot, start, start);
            }
        }
        scouts
    }

    /// Whose turn it is; `None` once nobody acts any more.
    #[must_use]
    pub fn due(&self) -> Option<RobotId> {
        match self.order.due() {
            Due::Robot(robot) => Some(robot),
            Due::Deadlock | Due::AllDone => None,
        }
    }

    /// Number of robots.
    #[must_use]
    pub fn count(&self) -> u16 {
        self.states.len() as u16
    }

    /// Who commands `robot`.
    ///
    /// # Panics
    /// If the mission has no such robot.
    #[must_use]
    pub fn leader(&self, robot: RobotId) -> Leader {
        self.states[usize::from(robot.0)].leader
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

    /// Adds a route of an earlier life, which [`Scouts::recall`] needs.
    pub fn recall_route(&mut self, route: Route) {
        self.routes.insert(route);
    }

    /// Keeps the points of a route until a command announces it.
    ///
    /// # Errors
    /// If the mission has no such robot.
    pub fn offer(&mut self, announcement: Announcement) -> Result<(), Refusal> {
        let Announcement { robot, route, .. } = announcement;
        let robots = self.count();
        let unknown = Refusal::WrongRobot { robots, got: robot.0.into() };
        let offers = self.offers.get_mut(usize::from(robot.0)).ok_or(unknown)?;
        if !offers.contains(&route) {
            offers.truncate(OFFERS_MAX - 1);
            offers.push_front(route);
        }
        Ok(())
    }

    /// How the mission stands: reached once the rover stands at the goal and has no further point to go to; lost if it is
    /// stranded; a deadlock if nobody can act, the rover has given up, or the robot that is due has used up its actions.
    #[must_use]
    pub fn status(&self) -> Status {
        for state in &self.states {
            let Vehicle::Driver { goal, goal_radius_m, .. } = state.robot.vehicle else { continue };
            let Travel { at, .. } = state.travel;
            let arrived = at.distance_m(goal) <= goal_radius_m + START_TOLERANCE_M;
            match state.standing {
                Standing::Stranded => return Status::Lost,
                _ if arrived && !state.travel.is_under_way() => return Status::Goal,
                Standing::Done => return Status::Deadlock,
                Standing::Active => {}
            }
        }
        match self.due() {
            Some(robot) if self.states[usize::from(robot.0)].actions < self.actions_max => Status::Underway,
            _ => Status::Deadlock,
        }
    }

    /// Why the robot that is due shall not execute `action`, if there is a reason.
    #[must_use]
    pub fn refusal(&self, action: Action) -> Option<Refusal> {
        let robot = self.due()?;
        let state = self.states.get(usize::from(robot.0))?;
        let needs = |need: &str| Some(Refusal::malformed("command.action", need, action));
        match (state.robot.vehicle, action) {
            (_, Action::Hold | Action::Wait | Action::Done) => None,
            (_, Action::Announce(id)) => self.refusal_of_route(robot, id),
            (Vehicle::Driver { .. }, Action::Drive) => match self.next(state) {
                None => needs("an announced route with a point to go to"),
                Some(to) => {
                    let got = self.hazard(state.travel.at, to);
                    let need = self.hazard_max;
                    (got > need).then_some(Refusal::Vetoed { action, need, got })
                }
            },
            (Vehicle::Helicopter { .. }, Action::Fly) => match self.next(state) {
                None => needs("an announced route with a point to go to"),
                Some(to) => beyond_budget(state, state.travel.at.distance_m(to)),
            },
            (Vehicle::Driver { .. } | Vehicle::Rover { .. }, _) => {
                needs("drive, announce, wait, done or hold: the robot is a rover on uncertain ground")
            }
            (Vehicle::Helicopter { .. }, _) => {
                needs("fly, announce, wait, done or hold: the robot is a helicopter")
            }
        }
    }

    /// Why the robot shall not announce the route, if there is a reason.
    fn refusal_of_route(&self, robot: RobotId, id: RouteId) -> Option<Refusal> {
        let state = &self.states[usize::from(robot.0)];
        let Some(route) = self.offered(robot, id) else { return Some(Refusal::UnknownRoute { route: id }) };
        let lattice = self.ground.lattice();
        if let Some(outside) = route.waypoints().iter().find(|at| !lattice.contains(point(**at))) {
            return Some(Refusal::malformed("route.waypoints", "points on the map", outside));
        }
        let begins_m = route.waypoints()[0].distance_m(state.travel.at);
        if begins_m > START_TOLERANCE_M {
            let need = format!("to begin where the robot is, at {}", state.travel.at);
            return Some(Refusal::malformed("route.waypoints", &need, route.waypoints()[0]));
        }
        beyond_budget(state, route.length_m())
    }

    /// A route that the planner of `robot` has told, or one that was announced before.
    fn offered(&self, robot: RobotId, id: RouteId) -> Option<&Route> {
        let offers = &self.offers[usize::from(robot.0)];
        offers.iter().find(|route| route.id() == id).or_else(|| self.routes.get(id))
    }

    /// The point that a robot goes to next on its route.
    fn next(&self, state: &ScoutState) -> Option<Waypoint> {
        let Travel { route, reached, .. } = state.travel;
        self.routes.get(route?)?.waypoints().get(reached as usize + 1).copied()
    }

    /// The largest probability of getting stuck in a cell between two points, as far as it is known.
    fn hazard(&self, from: Waypoint, to: Waypoint) -> f64 {
        let mut hazard = 0.0_f64;
        let segment = Segment { from: point(from), to: point(to) };
        let _ = traverse(self.ground.lattice(), segment, |cell, _| {
            let stuck = match self.seen[cell] {
                true => f64::from(u8::from(self.ground.speed(cell) == Speed::Zero)),
                false => self.prior[cell].probability(DriveSpeed::Zero),
            };
            hazard = hazard.max(stuck);
            ControlFlow::<()>::Continue(())
        });
        hazard
    }

    /// What is done at the deadline: on along the announced route if the guard lets that pass, else hold; never wait.
    #[must_use]
    pub fn fallback(&self) -> Fallback {
        let hold = Fallback { action: Action::Hold, origin: contract::Origin::Hold };
        let Some(robot) = self.due() else { return hold };
        let action = match self.states[usize::from(robot.0)].robot.vehicle {
            Vehicle::Helicopter { .. } => Action::Fly,
            Vehicle::Driver { .. } | Vehicle::Rover { .. } => Action::Drive,
        };
        if self.refusal(action).is_some() {
            return hold;
        }
        Fallback { action, origin: contract::Origin::Policy }
    }

    /// Executes `action`, which was not refused, at `decision` of the robot that is due, and takes note of it.
    ///
    /// # Panics
    /// If nobody is due.
    pub fn execute(&mut self, decision: Decision, leader: Leader, action: Action) -> (RobotId, Execution) {
        let robot = self.due().expect("a mission underway has a robot that is due");
        if let Action::Announce(id) = action
            && let Some(route) = self.offered(robot, id).cloned()
        {
            self.routes.insert(route);
            self.offers[usize::from(robot.0)].clear();
        }
        let outcome = self.take(robot, decision, leader, action);
        let execution = Execution {
            outcome,
            pose: Pose { cell: outcome.to, height_m: 0.0 },
            collected: Collected::default(),
            steps: self.states.iter().map(|state| state.actions).max().unwrap_or_default(),
            visits: 0,
            status: self.status(),
        };
        (robot, execution)
    }

    /// Takes note of a decision of an earlier life, whose route, if it announced one, is recalled already.
    ///
    /// # Panics
    /// If another robot was due; the digest chain of a journal is checked when it is opened.
    pub fn recall(&mut self, record: &Record) {
        self.take(record.robot, record.decision, record.leader, record.action);
    }

    /// All of them, as published with `state`.
    #[must_use]
    pub fn team(&self, state: &State) -> Team {
        let member = |(number, scout): (u16, &ScoutState)| Member {
            robot: scout.robot,
            at: scout.at,
            ready_at_ns: self.order.ready_at_ns(RobotId(number)),
            standing: scout.standing,
            leader: scout.leader,
            last: scout.last,
            travel: Some(Travel {
                waits: self.order.readiness(RobotId(number)) == crate::turn_order::Readiness::Parked,
                ..scout.travel
            }),
        };
        Team {
            run: state.run,
            decision: state.decision,
            digest: state.digest,
            due: self.due().or(self.actor).unwrap_or_default(),
            actor: self.actor,
            members: (0..).zip(&self.states).map(member).collect(),
        }
    }

    /// What `action` of `robot` comes to.
    fn effect(&self, robot: RobotId, action: Action) -> Effect {
        let state = &self.states[usize::from(robot.0)];
        let (from, here) = (state.at.cell, state.travel.at);
        let stays = |branch, seconds| {
            let flight = Flight { flight_time_s: seconds, flights: 1, ..Flight::default() };
            Effect { outcome: Outcome { branch, from, to: from, flight }, at: here }
        };
        if state.fails_at == Some(state.actions + 1) {
            return stays(Branch::Stranded, 1.0);
        }
        let goes = |branch, at: Waypoint, range_m, seconds| {
            let flight = Flight { range_m, flight_time_s: seconds, flights: 1, ..Flight::default() };
            Effect { outcome: Outcome { branch, from, to: self.cell(at), flight }, at }
        };
        match (action, self.next(state), state.robot.vehicle) {
            (Action::Drive, Some(to), _) => {
                let drive = self.ground.drive(here, to);
                let seconds = drive.duration_sol * SOL_HOURS * 3600.0;
                match drive.end {
                    DriveEnd::Stuck { .. } => {
                        let at = Waypoint { x_m: drive.at.x_m, y_m: drive.at.y_m };
                        goes(Branch::Stranded, at, drive.length_m, seconds)
                    }
                    DriveEnd::Arrived | DriveEnd::OutOfTime => {
                        goes(Branch::Intended, to, drive.length_m, seconds)
                    }
                }
            }
            (Action::Fly, Some(to), Vehicle::Helicopter { speed_mps, .. }) => {
                let range_m = here.distance_m(to);
                goes(Branch::Intended, to, range_m, range_m / speed_mps)
            }
            (Action::Wait | Action::Done, ..) => stays(Branch::Held, 0.0),
            _ => stays(Branch::Held, 1.0),
        }
    }

    /// Takes note of an action; what it came to.
    fn take(&mut self, robot: RobotId, decision: Decision, leader: Leader, action: Action) -> Outcome {
        let Effect { outcome, at } = self.effect(robot, action);
        let is_stranded = outcome.branch == Branch::Stranded;
        match action {
            Action::Wait if !is_stranded => self.order.park(robot),
            Action::Done if !is_stranded => self.order.finish(robot),
            _ => self.order.act(robot, duration_ns(outcome.flight.flight_time_s)),
        }
        self.actor = Some(robot);
        let number = usize::from(robot.0);
        let legs = match action {
            Action::Announce(id) => self.routes.get(id).map(|route| route.waypoints().len() as u32 - 1),
            _ => None,
        };
        let before = self.states[number];
        let state = &mut self.states[number];
        (state.last, state.leader) = (Some(decision), leader);
        state.actions += 1;
        let travel = &mut state.travel;
        match action {
            _ if is_stranded => {
                state.standing = Standing::Stranded;
                self.order.finish(robot);
            }
            Action::Announce(id) => {
                (travel.route, travel.announced) = (Some(id), Some(decision));
                (travel.reached, travel.legs) = (0, legs.unwrap_or_default());
            }
            Action::Drive | Action::Fly if outcome.branch == Branch::Intended => {
                travel.reached += 1;
                travel.moved = Some(decision);
                if action == Action::Fly {
                    travel.flown_m += outcome.flight.range_m;
                }
            }
            Action::Done => state.standing = Standing::Done,
            _ => {}
        }
        (state.travel.at, state.at.cell) = (at, outcome.to);
        if let (Action::Drive | Action::Fly, Some(to)) = (action, self.next(&before)) {
            // A robot that fails on the spot has gone nowhere.
            let to = if is_stranded && at == before.travel.at { at } else { to };
            self.see(&before.robot, before.travel.at, to);
        }
        outcome
    }

    /// Takes note of what a robot sees between two points.
    fn see(&mut self, robot: &Robot, from: Waypoint, to: Waypoint) {
        for cell in self.ground.seen(robot.sensor, from, to) {
            self.seen[cell] = true;
        }
    }

    fn cell(&self, at: Waypoint) -> Cell {
        self.grid.cell(self.ground.lattice().cell(point(at)))
    }
}

/// Why a helicopter shall not fly `length_m` more metres, if there is a reason.
fn beyond_budget(state: &ScoutState, length_m: f64) -> Option<Refusal> {
    let Vehicle::Helicopter { budget_m, .. } = state.robot.vehicle else { return None };
    let need = budget_m - state.travel.flown_m;
    (length_m > need + BUDGET_TOLERANCE_M).then_some(Refusal::BeyondBudget { need, got: length_m })
}

fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}
