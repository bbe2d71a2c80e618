//! The robots of a mission that is not a single hopper's: who acts next, what an action comes to, and how the mission
//! stands after it.

mod cover;
mod roster;
mod scout;
mod turn_order;

use contract::{
    Action, Announcement, Brief, Decision, Leader, Record, Refusal, RobotId, Route, RouteId, State, Status,
    Team,
};
use scenario::Fleet;
use terrain::Terrain;

use crate::dynamics::Execution;
use crate::guard::Fallback;
use cover::CoverTeam;
use roster::Roster;
use scout::ScoutTeam;

/// The robots of a mission, and their task.
#[derive(Clone, Debug)]
pub struct RobotTeam {
    roster: Roster,
    task: Task,
}

#[derive(Clone, Debug)]
enum Task {
    /// Rovers cover ground.
    Cover(CoverTeam),
    /// A rover drives to a goal, and helicopters look ahead for it.
    Scout(Box<ScoutTeam>),
}

impl RobotTeam {
    /// The robots before their first action.
    ///
    /// # Panics
    /// If fleet, terrain and brief are not of one scenario.
    #[must_use]
    pub fn new(brief: &Brief, terrain: &Terrain, fleet: &Fleet) -> Self {
        let mut roster = Roster::new(brief, fleet);
        let task = if brief.scout.is_some() {
            Task::Scout(Box::new(ScoutTeam::new(&roster, brief, terrain)))
        } else {
            Task::Cover(CoverTeam::new(&mut roster, brief, terrain))
        };
        Self { roster, task }
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

    /// Cells visited by rovers that cover ground; 0 if that is not the task.
    #[must_use]
    pub fn visited_cells(&self) -> u64 {
        match &self.task {
            Task::Cover(cover) => cover.visited_cells(),
            Task::Scout(_) => 0,
        }
    }

    /// Simulated time from the beginning of the last action to that of the next, seconds.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        self.roster.elapsed_ns() as f64 / 1.0e9
    }

    /// How the mission stands.
    #[must_use]
    pub fn status(&self) -> Status {
        match &self.task {
            Task::Cover(cover) => cover.status(&self.roster),
            Task::Scout(scout) => scout.status(&self.roster),
        }
    }

    /// Why the robot that is due shall not execute `action`, if there is a reason.
    #[must_use]
    pub fn refusal(&self, terrain: &Terrain, action: Action) -> Option<Refusal> {
        let robot = self.due()?;
        match &self.task {
            Task::Cover(cover) => cover.refusal(&self.roster, terrain, robot, action),
            Task::Scout(scout) => scout.refusal(&self.roster, robot, action),
        }
    }

    /// What is done at the deadline: rovers that cover ground hold.
    #[must_use]
    pub fn fallback(&self) -> Fallback {
        let hold = Fallback { action: Action::Hold, origin: contract::Origin::Hold };
        match (&self.task, self.due()) {
            (Task::Scout(scout), Some(robot)) => scout.fallback(&self.roster, robot).unwrap_or(hold),
            _ => hold,
        }
    }

    /// Executes `action`, which was not refused, at `decision` of the robot that is due, and takes note of it.
    ///
    /// # Panics
    /// If nobody is due.
    pub fn execute(
        &mut self,
        terrain: &Terrain,
        decision: Decision,
        leader: Leader,
        action: Action,
    ) -> (RobotId, Execution) {
        let robot = self.due().expect("a mission underway has a robot that is due");
        let execution = match &mut self.task {
            Task::Cover(cover) => cover.execute(&mut self.roster, terrain, robot, decision, leader, action),
            Task::Scout(scout) => scout.execute(&mut self.roster, terrain, robot, decision, leader, action),
        };
        (robot, execution)
    }

    /// Takes note of a decision of an earlier life.
    ///
    /// # Panics
    /// If another robot was due; the digest chain of a journal is checked when it is opened.
    pub fn recall(&mut self, terrain: &Terrain, record: &Record) {
        match &mut self.task {
            Task::Cover(cover) => cover.recall(&mut self.roster, terrain, record),
            Task::Scout(scout) => scout.recall(&mut self.roster, record),
        }
    }

    /// Adds a route of an earlier life, which [`RobotTeam::recall`] needs.
    pub fn recall_route(&mut self, route: Route) {
        if let Task::Scout(scout) = &mut self.task {
            scout.recall_route(route);
        }
    }

    /// Keeps the points of a route until a command announces it.
    ///
    /// # Errors
    /// If the mission has no such robot, or its robots have no routes.
    pub fn offer(&mut self, announcement: Announcement) -> Result<(), Refusal> {
        match &mut self.task {
            Task::Cover(_) => {
                Err(Refusal::malformed("route", "a mission whose robots have routes", "another"))
            }
            Task::Scout(scout) => scout.offer(announcement),
        }
    }

    /// The route with that fingerprint, if it was announced.
    #[must_use]
    pub fn route(&self, id: RouteId) -> Option<&Route> {
        match &self.task {
            Task::Cover(_) => None,
            Task::Scout(scout) => scout.route(id),
        }
    }

    /// All routes that were announced.
    pub fn routes(&self) -> impl Iterator<Item = &Route> {
        let scout = match &self.task {
            Task::Cover(_) => None,
            Task::Scout(scout) => Some(scout),
        };
        scout.into_iter().flat_map(|scout| scout.routes())
    }

    /// All of them, as published with `state`.
    #[must_use]
    pub fn team(&self, state: &State) -> Team {
        self.roster.team(state, |robot| match &self.task {
            Task::Cover(_) => None,
            Task::Scout(scout) => Some(scout.travel(robot)),
        })
    }
}
