//! Robots that go from point to point: a rover on ground of uncertain speed, and helicopters that look ahead for it.
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
    Action, Announcement, Branch, Brief, Cell, Collected, Decision, DriveSpeed, Flight, Grid, Leader, Origin,
    Outcome, Placement, Pose, Record, Refusal, Robot, RobotId, Route, RouteId, Routes, SpeedPrior, Standing,
    Status, Travel, Vehicle, Waypoint,
};
use rover::{DriveEnd, Point, SOL_HOURS, Segment, Speed, traverse};
use scout_world::TrueGround;
use terrain::Terrain;

use super::roster::{Roster, Turn};
use super::turn_order::duration_ns;
use crate::dynamics::Execution;
use crate::guard::Fallback;

/// Announced routes that are kept for each robot until a command names one of them.
const OFFERS_MAX: usize = 4;

/// How far a flight may be beyond its budget, metres: the sum of its legs is rounded.
const BUDGET_TOLERANCE_M: f64 = 1e-6;

/// How far the first point of a route may be from where the robot stands, metres.
const START_TOLERANCE_M: f64 = 1e-6;

/// How far robots are on their routes, and what their sensors have shown.
#[derive(Clone, Debug)]
pub struct ScoutTeam {
    /// In the order of the robots' numbers; so are `offers`.
    travels: Vec<Travel>,
    grid: Grid,
    ground: TrueGround,
    prior: Vec<SpeedPrior>,
    /// Which cells a sensor has shown, in index order.
    seen: Vec<bool>,
    /// All routes that were announced.
    routes: Routes,
    /// Routes received from planners that no command has named yet.
    offers: Vec<VecDeque<Route>>,
    hazard_max: f64,
}

/// What an action comes to.
struct Arrival {
    outcome: Outcome,
    /// Where the robot is afterwards.
    at: Waypoint,
}

impl ScoutTeam {
    /// Before the first action: the rover sees where it stands.
    ///
    /// # Panics
    /// If the terrain has no speeds, or a robot goes from cell to cell; scenarios are checked.
    #[must_use]
    pub fn new(roster: &Roster, brief: &Brief, terrain: &Terrain) -> Self {
        assert_eq!(terrain.prior.len(), terrain.cells.len(), "uncertain ground has a prior for each cell");
        let start = |robot: &Robot| robot.vehicle.start().expect("a scenario with scouts has starts");
        let travels = roster.entries().map(|(_, entry)| Travel::from_start(start(&entry.robot))).collect();
        let ground =
            TrueGround::new(brief.grid, &terrain.cells).expect("a grid is within the limits of a lattice");
        let mut routes = Routes::default();
        routes.begin(brief.run);
        let mut team = Self {
            travels,
            grid: brief.grid,
            ground,
            prior: terrain.prior.clone(),
            seen: vec![false; brief.grid.cells()],
            routes,
            offers: vec![VecDeque::new(); roster.count().into()],
            hazard_max: brief.guard.hazard_max,
        };
        for (_, entry) in roster.entries() {
            if let Vehicle::Driver { start, .. } = entry.robot.vehicle {
                team.see(&entry.robot, start, start);
            }
        }
        team
    }

    /// How far `robot` is on its route.
    #[must_use]
    pub fn travel(&self, robot: RobotId) -> Travel {
        self.travels[usize::from(robot.0)]
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

    /// Adds a route of an earlier life, which [`ScoutTeam::recall`] needs.
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

    /// How the mission stands: reached once the rover stands at the goal and has no further point to go to; lost if it is
    /// stranded; a deadlock if nobody can act, the rover has given up, or the robot that is due has used up its actions.
    #[must_use]
    pub fn status(&self, roster: &Roster) -> Status {
        for (robot, entry) in roster.entries() {
            let Vehicle::Driver { goal, goal_radius_m, .. } = entry.robot.vehicle else { continue };
            let travel = self.travel(robot);
            let arrived = travel.at.distance_m(goal) <= goal_radius_m + START_TOLERANCE_M;
            match entry.standing {
                Standing::Stranded => return Status::Lost,
                _ if arrived && !travel.is_under_way() => return Status::Goal,
                Standing::Done => return Status::Deadlock,
                Standing::Active => {}
            }
        }
        match roster.due() {
            Some(robot) if !roster.is_spent(robot) => Status::Underway,
            _ => Status::Deadlock,
        }
    }

    /// Why `robot`, which is due, shall not execute `action`, if there is a reason.
    #[must_use]
    pub fn refusal(&self, roster: &Roster, robot: RobotId, action: Action) -> Option<Refusal> {
        let (vehicle, travel) = (roster.entry(robot).robot.vehicle, self.travel(robot));
        let needs = |need: &str| Some(Refusal::malformed("command.action", need, action));
        match (vehicle, action) {
            (_, Action::Hold | Action::Wait | Action::Done) => None,
            (_, Action::Announce(id)) => self.refusal_of_route(vehicle, robot, id),
            (Vehicle::Driver { .. }, Action::Drive) => match self.next(travel) {
                None => needs("an announced route with a point to go to"),
                Some(to) => {
                    let got = self.hazard(travel.at, to);
                    let need = self.hazard_max;
                    (got > need).then_some(Refusal::Vetoed { action, need, got })
                }
            },
            (Vehicle::Helicopter { .. }, Action::Fly) => match self.next(travel) {
                None => needs("an announced route with a point to go to"),
                Some(to) => beyond_budget(vehicle, travel, travel.at.distance_m(to)),
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
    fn refusal_of_route(&self, vehicle: Vehicle, robot: RobotId, id: RouteId) -> Option<Refusal> {
        let travel = self.travel(robot);
        let Some(route) = self.offered(robot, id) else { return Some(Refusal::UnknownRoute { route: id }) };
        let lattice = self.ground.lattice();
        if let Some(outside) = route.waypoints().iter().find(|at| !lattice.contains(point(**at))) {
            return Some(Refusal::malformed("route.waypoints", "points on the map", outside));
        }
        let begins_m = route.waypoints()[0].distance_m(travel.at);
        if begins_m > START_TOLERANCE_M {
            let need = format!("to begin where the robot is, at {}", travel.at);
            return Some(Refusal::malformed("route.waypoints", &need, route.waypoints()[0]));
        }
        beyond_budget(vehicle, travel, route.length_m())
    }

    /// A route received from the planner of `robot`, or one that was announced before.
    fn offered(&self, robot: RobotId, id: RouteId) -> Option<&Route> {
        let offers = &self.offers[usize::from(robot.0)];
        offers.iter().find(|route| route.id() == id).or_else(|| self.routes.get(id))
    }

    /// The point that a robot goes to next on its route.
    fn next(&self, travel: Travel) -> Option<Waypoint> {
        let Travel { route, reached, .. } = travel;
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

    /// What `robot`, which is due, does at the deadline: on along the announced route. `None` if the guard does not let that
    /// pass.
    #[must_use]
    pub fn fallback(&self, roster: &Roster, robot: RobotId) -> Option<Fallback> {
        let action = match roster.entry(robot).robot.vehicle {
            Vehicle::Helicopter { .. } => Action::Fly,
            Vehicle::Driver { .. } | Vehicle::Rover { .. } => Action::Drive,
        };
        let is_refused = self.refusal(roster, robot, action).is_some();
        (!is_refused).then_some(Fallback { action, origin: Origin::Policy })
    }

    /// Executes `action`, which was not refused, at `decision` of `robot`, which is due, and takes note of it.
    pub fn execute(
        &mut self,
        roster: &mut Roster,
        terrain: &Terrain,
        robot: RobotId,
        decision: Decision,
        leader: Leader,
        action: Action,
    ) -> Execution {
        if let Action::Announce(id) = action
            && let Some(route) = self.offered(robot, id).cloned()
        {
            self.routes.insert(route);
            self.offers[usize::from(robot.0)].clear();
        }
        let outcome = self.take(roster, robot, decision, leader, action);
        Execution {
            outcome,
            pose: Pose {
                cell: outcome.to,
                height_m: terrain.ground(outcome.to).map_or(0.0, |ground| ground.height_m),
            },
            collected: Collected::default(),
            steps: roster.steps(),
            visits: 0,
            status: self.status(roster),
        }
    }

    /// Takes note of a decision of an earlier life, whose route, if it announced one, is recalled already.
    ///
    /// # Panics
    /// If another robot was due.
    pub fn recall(&mut self, roster: &mut Roster, record: &Record) {
        self.take(roster, record.robot, record.decision, record.leader, record.action);
    }

    /// What `action` of `robot` comes to.
    fn arrival(&self, roster: &Roster, robot: RobotId, action: Action) -> Arrival {
        let (entry, travel) = (roster.entry(robot), self.travel(robot));
        let (from, here) = (entry.at.cell, travel.at);
        let stays = |branch, seconds| {
            let flight = Flight { flight_time_s: seconds, flights: 1, ..Flight::default() };
            Arrival { outcome: Outcome { branch, from, to: from, flight }, at: here }
        };
        if roster.fails_now(robot) {
            return stays(Branch::Stranded, 1.0);
        }
        let goes = |branch, at: Waypoint, range_m, seconds| {
            let flight = Flight { range_m, flight_time_s: seconds, flights: 1, ..Flight::default() };
            Arrival { outcome: Outcome { branch, from, to: self.cell(at), flight }, at }
        };
        match (action, self.next(travel), entry.robot.vehicle) {
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
    fn take(
        &mut self,
        roster: &mut Roster,
        robot: RobotId,
        decision: Decision,
        leader: Leader,
        action: Action,
    ) -> Outcome {
        let Arrival { outcome, at } = self.arrival(roster, robot, action);
        let is_stranded = outcome.branch == Branch::Stranded;
        let turn = match action {
            Action::Wait if !is_stranded => Turn::Waits,
            Action::Done if !is_stranded => Turn::Ends,
            _ => Turn::Lasts(duration_ns(outcome.flight.flight_time_s)),
        };
        roster.act(robot, decision, leader, turn);
        let before = self.travel(robot);
        let travel = &mut self.travels[usize::from(robot.0)];
        match action {
            _ if is_stranded => roster.end(robot, Standing::Stranded),
            Action::Announce(id) => {
                let legs = self.routes.get(id).map(|route| route.waypoints().len() as u32 - 1);
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
            _ => {}
        }
        travel.at = at;
        let entry = *roster.entry(robot);
        roster.place(robot, Placement { cell: outcome.to, ..entry.at });
        if let (Action::Drive | Action::Fly, Some(to)) = (action, self.next(before)) {
            // A robot that fails on the spot has gone nowhere.
            let to = if is_stranded && at == before.at { at } else { to };
            self.see(&entry.robot, before.at, to);
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
fn beyond_budget(vehicle: Vehicle, travel: Travel, length_m: f64) -> Option<Refusal> {
    let Vehicle::Helicopter { budget_m, .. } = vehicle else { return None };
    let need = budget_m - travel.flown_m;
    (length_m > need + BUDGET_TOLERANCE_M).then_some(Refusal::BeyondBudget { need, got: length_m })
}

fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}
