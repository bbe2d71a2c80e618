//! The robots of a mission that is not that of a hopper alone: who acts next, what an action comes to, and how the mission
//! stands after it.

mod cover;
mod hop;
mod mixed;
mod roster;
mod scout;
mod travels;
mod turn_order;

use contract::{
    Action, Announcement, Brief, Cell, Leader, Origin, Pose, Record, Refusal, RobotId, Route, RouteId, State,
    Status, Team,
};
use scenario::Fleet;
use terrain::Terrain;

use crate::Mission;
use crate::dynamics::Execution;
use crate::guard::Fallback;
use crate::mission::opening_status;
use cover::CoverTeam;
use hop::HopTeam;
use mixed::MixedTeam;
use roster::Roster;
use scout::ScoutTeam;
use travels::Travels;

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
    /// A hopper goes its way, and helicopters look ahead for it.
    Hop(HopTeam),
    /// Each robot has a task of its own.
    Mixed(Box<MixedTeam>),
}

impl RobotTeam {
    /// The robots before their first action.
    ///
    /// # Panics
    /// If fleet, terrain and brief are not of one scenario.
    #[must_use]
    pub fn new(brief: &Brief, terrain: &Terrain, fleet: &Fleet) -> Self {
        let mut roster = Roster::new(brief, fleet);
        let task = if brief.mixed.is_some() {
            Task::Mixed(Box::new(MixedTeam::new(&mut roster, brief, terrain)))
        } else if brief.is_of_hopper() {
            Task::Hop(HopTeam::new(&roster, brief))
        } else if brief.scout.is_some() {
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

    /// Whether it is a hopper's turn: its commands are judged as those of a hopper that is alone.
    #[must_use]
    pub fn is_turn_of_hopper(&self) -> bool {
        self.due().is_some_and(|robot| self.roster.entry(robot).robot.vehicle.hops())
    }

    /// Where the hopper stands that is due, and where it shall go, if it has a goal of its own.
    #[must_use]
    pub fn own_way(&self, terrain: &Terrain) -> Option<(Pose, Cell)> {
        let (robot, Task::Mixed(mixed)) = (self.due()?, &self.task) else { return None };
        let goal = self.roster.entry(robot).robot.vehicle.hop_goal()?;
        Some((mixed.pose(&self.roster, terrain, robot), goal))
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

    /// Simulated time from the beginning of the last action to that of the next, seconds.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        self.roster.elapsed_ns() as f64 / 1.0e9
    }

    /// How the mission stands before the first action, and how many cells are visited.
    #[must_use]
    pub fn opening(&self, brief: &Brief) -> (Status, u64) {
        match &self.task {
            Task::Cover(cover) => (cover.status(&self.roster), cover.visited_cells()),
            Task::Scout(scout) => (scout.status(&self.roster), 0),
            Task::Hop(_) => (opening_status(brief), 0),
            Task::Mixed(mixed) => (mixed.status(&self.roster), mixed.visited_cells()),
        }
    }

    /// Why the robot that is due shall not execute `action`, if there is a reason; of a hopper, only whether another robot is
    /// where it aims.
    #[must_use]
    pub fn refusal(&self, terrain: &Terrain, action: Action) -> Option<Refusal> {
        let robot = self.due()?;
        match &self.task {
            Task::Cover(cover) => cover.refusal(&self.roster, terrain, robot, action),
            Task::Scout(scout) => scout.refusal(&self.roster, robot, action),
            Task::Hop(_) if self.is_turn_of_hopper() => None,
            Task::Hop(hop) => hop.refusal(&self.roster, robot, action),
            Task::Mixed(mixed) => mixed.refusal(&self.roster, terrain, robot, action),
        }
    }

    /// What is done at the deadline, unless it is a hopper's turn: who has an announced route goes on along it, all others
    /// hold.
    #[must_use]
    pub fn fallback(&self, terrain: &Terrain) -> Fallback {
        let along = |robot| self.roster.entry(robot).robot.vehicle.along_route();
        let action = self.due().and_then(along).filter(|action| self.refusal(terrain, *action).is_none());
        match action {
            Some(action) => Fallback { action, origin: Origin::Policy },
            None => Fallback { action: Action::Hold, origin: Origin::Hold },
        }
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
        let (roster, terrain, decision) = (&mut self.roster, &mission.terrain, state.decision);
        let execution = match &mut self.task {
            Task::Cover(cover) => cover.execute(roster, terrain, robot, decision, leader, action),
            Task::Scout(scout) => scout.execute(roster, terrain, robot, decision, leader, action),
            Task::Hop(hop) => hop.execute(roster, mission, state, robot, leader, action),
            Task::Mixed(mixed) => mixed.execute(roster, mission, state, robot, leader, action),
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
            Task::Hop(hop) => hop.recall(&mut self.roster, record),
            Task::Mixed(mixed) => mixed.recall(&mut self.roster, terrain, record),
        }
    }

    /// Adds a route of an earlier life, which [`RobotTeam::recall`] needs.
    pub fn recall_route(&mut self, route: Route) {
        if let Some(travels) = self.travels_mut() {
            travels.recall_route(route);
        }
    }

    /// Keeps the points of a route until a command announces it.
    ///
    /// # Errors
    /// If the mission has no such robot, or its robots have no routes.
    pub fn offer(&mut self, announcement: Announcement) -> Result<(), Refusal> {
        match self.travels_mut() {
            Some(travels) => travels.offer(announcement),
            None => Err(Refusal::malformed("route", "a mission whose robots have routes", "another")),
        }
    }

    /// The route with that fingerprint, if it was announced.
    #[must_use]
    pub fn route(&self, id: RouteId) -> Option<&Route> {
        self.travels()?.route(id)
    }

    /// All routes that were announced.
    pub fn routes(&self) -> impl Iterator<Item = &Route> {
        self.travels().into_iter().flat_map(Travels::routes)
    }

    /// All of them, as published with `state`.
    #[must_use]
    pub fn team(&self, state: &State) -> Team {
        let travels = self.travels();
        self.roster.team(state, |robot| travels.and_then(|travels| travels.get(robot)))
    }

    fn travels(&self) -> Option<&Travels> {
        match &self.task {
            Task::Cover(_) => None,
            Task::Scout(scout) => Some(scout.travels()),
            Task::Hop(hop) => Some(hop.travels()),
            Task::Mixed(mixed) => Some(mixed.travels()),
        }
    }

    fn travels_mut(&mut self) -> Option<&mut Travels> {
        match &mut self.task {
            Task::Cover(_) => None,
            Task::Scout(scout) => Some(scout.travels_mut()),
            Task::Hop(hop) => Some(hop.travels_mut()),
            Task::Mixed(mixed) => Some(mixed.travels_mut()),
        }
    }
}
