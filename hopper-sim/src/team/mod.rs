//! The robots of a mission: who acts next, what an action comes to, and how the mission stands after it.
//!
//! The turn of a robot is one path, whatever it is and whatever it shall do: it is due; its body (`body`) refuses the action or
//! acts; what the action has come to is noted in the order of turns, on the routes and in what is covered; it looks around; its
//! goal is reached (`goal`) or cannot be any more (`part`). A hopper alone is a team of one.

mod body;
mod coverage;
mod goal;
mod part;
mod roster;
mod travels;
mod turn_order;
mod uncertain_ground;

use std::collections::BTreeMap;
use std::sync::Arc;

use contract::{
    Account, Action, Announcement, Body, Branch, Brief, Cell, Detail, DetailId, Flight, Goal, Leader,
    Outcome, Placement, Policy, Pose, Record, Refusal, RobotId, Route, RouteId, Standing, State, Status,
    Team, Waypoint,
};
use rover::Drive;
use terrain::Terrain;

use crate::Execution;
use crate::Mission;
use crate::dynamics::{self, MotionModel};
use crate::guard::Fallback;
use body::Movement;
use coverage::Coverage;
use roster::{Act, Roster, Turn};
use travels::{Arrival, Travels};
use turn_order::duration_ns;
use uncertain_ground::UncertainGround;

/// The robots of a mission.
#[derive(Clone, Debug)]
pub struct RobotTeam {
    brief: Brief,
    roster: Roster,
    /// Where hops end.
    model: Arc<dyn MotionModel>,
    /// What the model told of each hopper's last action.
    details: BTreeMap<RobotId, Detail>,
    travels: Travels,
    /// Ground of uncertain speed, if robots drive on it.
    ground: Option<UncertainGround>,
    /// What rovers have covered, if they cover ground.
    coverage: Option<Coverage>,
}

impl RobotTeam {
    /// The robots before their first action; some will fail. A robot with nothing to do starts as done.
    ///
    /// # Panics
    /// If faults, terrain and brief are not of one scenario.
    #[must_use]
    pub fn new(mission: &Mission) -> Self {
        let Mission { brief, terrain, faults, .. } = mission;
        let mut roster = Roster::new(brief, faults);
        let travels = Travels::new(brief);
        let covers = brief.robots.iter().any(|robot| matches!(robot.goal, Goal::Cover(_)));
        let drives = brief.robots.iter().any(|robot| robot.body.drives());
        let ground = drives.then(|| UncertainGround::new(&roster, brief, terrain));
        let coverage = covers.then(|| Coverage::new(&mut roster, brief, terrain));
        let (model, details) = (dynamics::of(mission), BTreeMap::new());
        let mut team = Self { brief: brief.clone(), roster, model, details, travels, ground, coverage };
        for robot in (0..team.count()).map(RobotId) {
            team.look_around(terrain, robot);
            team.end_if_over(terrain, robot, brief.reading.opening_steps);
        }
        team
    }

    /// Whose turn it is; `None` once nobody acts any more.
    #[must_use]
    pub fn due(&self) -> Option<RobotId> {
        self.roster.due()
    }

    /// How many robots there are.
    #[must_use]
    pub fn count(&self) -> u16 {
        self.roster.count()
    }

    /// Who commands `robot`.
    ///
    /// # Panics
    /// If the mission has no such robot.
    #[must_use]
    pub fn leader(&self, robot: RobotId) -> Leader {
        self.roster.leader(robot)
    }

    /// Simulated time from the beginning of the last action to that of the next, seconds: of a hopper alone the whole action, else less
    /// if another robot acts meanwhile.
    #[must_use]
    pub fn elapsed_s(&self, outcome: &Outcome) -> f64 {
        if self.brief.has_team() { self.roster.elapsed_ns() as f64 / 1.0e9 } else { lasts_s(outcome) }
    }

    /// How the mission stands before the first action, and how many cells are visited.
    #[must_use]
    pub fn opening(&self) -> (Status, u64) {
        (self.status(self.brief.reading.opening_steps), self.visited_cells())
    }

    /// Why the robot that is due shall not execute `action`, if there is a reason.
    #[must_use]
    pub fn refusal(&self, terrain: &Terrain, action: Action) -> Option<Refusal> {
        self.refusal_of(terrain, self.due()?, action)
    }

    fn refusal_of(&self, terrain: &Terrain, robot: RobotId, action: Action) -> Option<Refusal> {
        body::of(&self.body(robot)).refusal(self, terrain, robot, action)
    }

    /// Whether the robot that is due may follow the policy of its planner at a deadline. A policy leads to one goal, so only a hopper
    /// whose mission it is may.
    #[must_use]
    pub fn follows_policies(&self) -> bool {
        self.brief.account == Account::Hopper && self.due().is_some_and(|robot| self.body(robot).hops())
    }

    /// What the robot that is due does at the deadline. `visits` are those of the state; the policy is that of the planner in
    /// command, if the robot may follow it.
    ///
    /// # Panics
    /// If nobody is due.
    #[must_use]
    pub fn fallback(&self, terrain: &Terrain, visits: u64, policy: Option<&Policy>) -> Fallback {
        let robot = self.due().expect("a mission underway has a robot that is due");
        body::of(&self.body(robot)).fallback(self, terrain, robot, visits, policy)
    }

    /// Executes `action`, which was not refused, at the decision of `state` of the robot that is due, and takes note of it.
    ///
    /// # Panics
    /// If nobody is due.
    pub fn execute(
        &mut self,
        mission: &Mission,
        state: &State,
        leader: Leader,
        action: Action,
    ) -> (RobotId, Execution) {
        let robot = self.due().expect("a mission underway has a robot that is due");
        let (terrain, decision) = (&mission.terrain, state.decision);
        let act = Act { robot, decision, leader, action };
        self.travels.keep_announced(robot, action);
        let movement = body::of(&self.body(robot)).movement(self, mission, &act);
        let outcome = movement.outcome();
        let comes_down = !matches!(outcome.branch, Branch::Stranded | Branch::RolledAway);
        let (hops, lands) = (self.body(robot).hops(), comes_down && action != Action::Wait);
        let detail = movement.detail().map_or(DetailId::NONE, Detail::id);
        let ground = |cell| terrain.ground(cell);
        let steps = match ground(outcome.from) {
            Some(ground) if hops && (lands || outcome.branch == Branch::RolledAway) => {
                state.steps + motion::steps(ground.soil, action, outcome.branch)
            }
            _ => state.steps,
        };
        self.take(terrain, &act, &movement, steps);
        let height_m =
            ground(outcome.to).or_else(|| ground(outcome.from)).map_or(0.0, |ground| ground.height_m);
        let pose = Pose { cell: outcome.to, height_m };
        let collected = if hops && lands {
            state.collected.landing(&terrain.treasures, outcome.to)
        } else {
            state.collected
        };
        let (pose, steps, visits) = match self.brief.account {
            Account::Hopper if hops => {
                let visits = lands && self.brief.is_visit(state.visits, outcome.to);
                (pose, steps, state.visits + u64::from(visits))
            }
            Account::Hopper => (state.pose, steps, state.visits),
            Account::Actions => (pose, self.roster.steps(), self.visited_cells()),
            Account::ActionsWithoutWaits => (pose, self.roster.steps_without_waits(), self.visited_cells()),
        };
        (robot, Execution { outcome, pose, detail, collected, steps, visits, status: self.status(steps) })
    }

    /// Takes note of a decision of an earlier life, whose route, if it announced one, is recalled already.
    ///
    /// # Panics
    /// If another robot was due; the digest chain of a journal is checked when it is opened.
    pub fn recall(&mut self, terrain: &Terrain, record: &Record) {
        let Record { robot, decision, leader, action, steps, .. } = *record;
        let movement = body::of(&self.body(robot)).recalled(self, record);
        self.take(terrain, &Act { robot, decision, leader, action }, &movement, steps);
    }

    /// Takes up the mission of a hopper alone behind its last decision, which is all that this needs.
    ///
    /// # Panics
    /// In another mission.
    pub fn resume(&mut self, terrain: &Terrain, last: &Record) {
        assert!(!self.brief.has_team(), "the last record is enough for a hopper alone only");
        self.roster.resume(last.robot, last.decision.0);
        self.recall(terrain, last);
    }

    /// Takes note of what an action has come to. `steps` are those of the hopper, where the mission counts them.
    fn take(&mut self, terrain: &Terrain, act: &Act, movement: &Movement, steps: u64) {
        match movement {
            Movement::InCells(landing) => {
                self.settle_in_cells(act, &landing.outcome);
                if let Some(detail) = &landing.detail {
                    self.recall_detail(act.robot, detail.clone());
                }
            }
            Movement::BetweenPoints(arrival, drive) => {
                self.settle_between_points(act, arrival, drive.as_ref())
            }
        }
        self.look_around(terrain, act.robot);
        self.end_if_over(terrain, act.robot, steps);
    }

    /// Takes note of an action of a robot that goes from cell to cell.
    fn settle_in_cells(&mut self, act: &Act, outcome: &Outcome) {
        let Act { robot, action, .. } = *act;
        let is_stranded = matches!(outcome.branch, Branch::Stranded | Branch::RolledAway);
        let turn = match action {
            Action::Wait if !is_stranded => Turn::Waits,
            _ => Turn::Lasts(duration_ns(lasts_s(outcome))),
        };
        self.roster.act(act, turn);
        let at = self.roster.entry(robot).at;
        let heading = match action {
            Action::Step(direction) if !is_stranded => direction,
            _ => at.heading,
        };
        self.roster.place(robot, Placement { cell: outcome.to, heading });
        if is_stranded {
            self.roster.end(robot, Standing::Stranded);
        }
        if let (Some(coverage), Goal::Cover(_)) = (&mut self.coverage, self.roster.entry(robot).robot.goal) {
            coverage.visit(&mut self.roster, robot);
        }
    }

    /// Takes note of an action of a robot that goes from point to point, and of what it sees on its way.
    fn settle_between_points(&mut self, act: &Act, arrival: &Arrival, drive: Option<&Drive>) {
        let Act { robot, action, .. } = *act;
        let seer = self.roster.entry(robot).robot;
        if let (Some(ground), Some(before)) = (&mut self.ground, self.travels.get(robot)) {
            // A robot that fails on the spot has gone nowhere, and shows nothing.
            let has_gone = arrival.outcome.branch != Branch::Stranded || arrival.at != before.at;
            if let (Action::Fly, true, Some(to)) = (action, has_gone, self.travels.next(before)) {
                ground.see_between(&seer, before.at, to);
            }
            if let Some(drive) = drive {
                ground.drove(robot, drive);
                if has_gone {
                    ground.see(&seer, drive.sensed.iter().copied());
                }
            }
        }
        self.travels.settle(&mut self.roster, act, arrival);
        if let (Branch::Halted, Some(ground)) = (arrival.outcome.branch, &mut self.ground) {
            ground.begin_stage(robot);
            self.travels.rejoin(&mut self.roster, robot);
        }
    }

    /// Adds what a robot that goes from cell to cell sees from where it is to what the guard of drives knows: planners of drives know
    /// it by the map.
    fn look_around(&mut self, terrain: &Terrain, robot: RobotId) {
        let Some(uncertain) = &mut self.ground else { return };
        let (grid, entry) = (self.brief.grid, self.roster.entry(robot));
        let (robot, at) = (entry.robot, entry.at.cell);
        let Some(ground) = terrain.ground(at) else { return };
        if let Some(view) = robot.sensor.around(&grid, ground.height_m) {
            let seen = view.cells(grid, at);
            uncertain.see(&robot, seen.filter_map(|cell| grid.index(cell)));
        }
    }

    /// What the motion model told of the last action of `robot`, which it needs for the next.
    #[must_use]
    pub fn detail(&self, robot: RobotId) -> Option<&Detail> {
        self.details.get(&robot)
    }

    /// Takes what the motion model told of the last action of `robot` in an earlier life.
    pub fn recall_detail(&mut self, robot: RobotId, detail: Detail) {
        self.details.insert(robot, detail);
    }

    /// Adds a route of an earlier life, which [`RobotTeam::recall`] needs.
    pub fn recall_route(&mut self, route: Route) {
        self.travels.recall_route(route);
    }

    /// Keeps the points of a route until a command announces it.
    ///
    /// # Errors
    /// If the mission has no such robot, or its robots have no routes.
    pub fn offer(&mut self, announcement: Announcement) -> Result<(), Refusal> {
        if !self.brief.has_routes() {
            return Err(Refusal::malformed("route", "a mission whose robots have routes", "another"));
        }
        self.travels.offer(announcement)
    }

    /// The route with that fingerprint, if it was announced.
    #[must_use]
    pub fn route(&self, id: RouteId) -> Option<&Route> {
        self.travels.route(id)
    }

    /// All routes that were announced.
    pub fn routes(&self) -> impl Iterator<Item = &Route> {
        self.travels.routes()
    }

    /// All of them, as published with `state`.
    #[must_use]
    pub fn team(&self, state: &State) -> Team {
        self.roster.team(state, |robot| self.travels.get(robot))
    }

    fn body(&self, robot: RobotId) -> Body {
        self.roster.entry(robot).robot.body
    }

    /// Whether a point lies on the map.
    fn is_on_map(&self, at: Waypoint) -> bool {
        match &self.ground {
            Some(ground) => ground.contains(at),
            None => self.brief.grid.contains(self.cell_of(at)),
        }
    }

    /// The cell of a point.
    fn cell_of(&self, at: Waypoint) -> Cell {
        match &self.ground {
            Some(ground) => ground.cell(at),
            None => at.cell_of(&self.brief.grid),
        }
    }
}

/// How long an action of a robot that goes from cell to cell lasts, seconds.
fn lasts_s(outcome: &Outcome) -> f64 {
    let Flight { flight_time_s, flights, .. } = outcome.flight;
    flight_time_s * f64::from(flights)
}
