//! The robots of a mission that is not a single hopper's: those that go from cell to cell, or those that go from point to
//! point.

use contract::{
    Action, Brief, Decision, Leader, Record, Refusal, RobotId, Route, RouteId, State, Status, Team,
};
use scenario::Fleet;
use terrain::Terrain;

use crate::dynamics::Execution;
use crate::guard::Fallback;
use crate::{Robots, Scouts};

/// The robots of a mission.
#[derive(Clone, Debug)]
pub enum RobotTeam {
    /// Rovers that cover ground.
    Cover(Robots),
    /// A rover that drives to a goal, and helicopters.
    Scout(Box<Scouts>),
}

impl RobotTeam {
    /// The robots before their first action.
    ///
    /// # Panics
    /// If fleet, terrain and brief are not of one scenario.
    #[must_use]
    pub fn new(brief: &Brief, terrain: &Terrain, fleet: &Fleet) -> Self {
        if brief.scout.is_some() {
            Self::Scout(Box::new(Scouts::new(brief, terrain, fleet)))
        } else {
            Self::Cover(Robots::new(brief, terrain, fleet))
        }
    }

    /// Whose turn it is; `None` once nobody acts any more.
    #[must_use]
    pub fn due(&self) -> Option<RobotId> {
        match self {
            Self::Cover(robots) => robots.due(),
            Self::Scout(scouts) => scouts.due(),
        }
    }

    /// Number of robots.
    #[must_use]
    pub fn count(&self) -> u16 {
        match self {
            Self::Cover(robots) => robots.count(),
            Self::Scout(scouts) => scouts.count(),
        }
    }

    /// Who commands `robot`.
    ///
    /// # Panics
    /// If the mission has no such robot.
    #[must_use]
    pub fn leader(&self, robot: RobotId) -> Leader {
        match self {
            Self::Cover(robots) => robots.leader(robot),
            Self::Scout(scouts) => scouts.leader(robot),
        }
    }

    /// Cells visited by rovers that cover ground.
    #[must_use]
    pub fn visited_cells(&self) -> u64 {
        match self {
            Self::Cover(robots) => robots.visited_cells(),
            Self::Scout(_) => 0,
        }
    }

    /// How the mission stands.
    #[must_use]
    pub fn status(&self) -> Status {
        match self {
            Self::Cover(robots) => robots.status(),
            Self::Scout(scouts) => scouts.status(),
        }
    }

    /// Why the robot that is due shall not execute `action`, if there is a reason.
    #[must_use]
    pub fn refusal(&self, terrain: &Terrain, action: Action) -> Option<Refusal> {
        match self {
            Self::Cover(robots) => robots.refusal(terrain, action),
            Self::Scout(scouts) => scouts.refusal(action),
        }
    }

    /// What is done at the deadline: rovers that cover ground hold.
    #[must_use]
    pub fn fallback(&self) -> Fallback {
        match self {
            Self::Cover(_) => Fallback { action: Action::Hold, origin: contract::Origin::Hold },
            Self::Scout(scouts) => scouts.fallback(),
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
        match self {
            Self::Cover(robots) => robots.execute(terrain, decision, leader, action),
            Self::Scout(scouts) => scouts.execute(decision, leader, action),
        }
    }

    /// Takes note of a decision of an earlier life.
    ///
    /// # Panics
    /// If another robot was due; the digest chain of a journal is checked when it is opened.
    pub fn recall(&mut self, terrain: &Terrain, record: &Record) {
        match self {
            Self::Cover(robots) => robots.recall(terrain, record),
            Self::Scout(scouts) => scouts.recall(record),
        }
    }

    /// Adds a route of an earlier life.
    pub fn recall_route(&mut self, route: Route) {
        if let Self::Scout(scouts) = self {
            scouts.recall_route(route);
        }
    }

    /// The route with that fingerprint, if it was announced.
    #[must_use]
    pub fn route(&self, id: RouteId) -> Option<&Route> {
        match self {
            Self::Cover(_) => None,
            Self::Scout(scouts) => scouts.route(id),
        }
    }

    /// All of them, as published with `state`.
    #[must_use]
    pub fn team(&self, state: &State) -> Team {
        match self {
            Self::Cover(robots) => robots.team(state),
            Self::Scout(scouts) => scouts.team(state),
        }
    }
}
