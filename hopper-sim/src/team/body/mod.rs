//! What each body may do, and what its actions come to.

use ::rover::Drive;
use contract::{Action, Branch, Detail, Flight, Origin, Outcome, Policy, Record, Refusal, RobotId, RouteId};
use terrain::Terrain;

use super::RobotTeam;
use super::travels::Arrival;
use crate::Mission;
use crate::dynamics::Landing;
use crate::guard::Fallback;

contract::rules! {
    /// What a body does.
    pub fn of(Body) -> Body;
    hopper => Hopper,
    rover => Rover,
    driver => Driver,
    helicopter => Helicopter,
}

/// A decision of a robot: what it does, and under whom.
pub use super::roster::Act;

/// What an action has come to.
#[derive(Clone, Debug)]
pub enum Movement {
    /// Of a robot that goes from cell to cell.
    InCells(Landing),
    /// Of one that goes from point to point, with the drive, if it was one.
    BetweenPoints(Arrival, Option<Drive>),
}

impl Movement {
    /// As it is recorded.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        match self {
            Movement::InCells(landing) => landing.outcome,
            Movement::BetweenPoints(arrival, _) => arrival.outcome,
        }
    }

    /// What the motion model tells beyond that.
    #[must_use]
    pub fn detail(&self) -> Option<&Detail> {
        match self {
            Movement::InCells(landing) => landing.detail.as_ref(),
            Movement::BetweenPoints(..) => None,
        }
    }
}

/// The actions of robots of one kind.
pub trait Body {
    /// Why `robot`, which is due, shall not execute `action`, if there is a reason.
    fn refusal(&self, team: &RobotTeam, terrain: &Terrain, robot: RobotId, action: Action)
    -> Option<Refusal>;

    /// What an action that was not refused comes to, drawn on the true ground.
    fn movement(&self, team: &RobotTeam, mission: &Mission, act: &Act) -> Movement;

    /// What an action of an earlier life has come to.
    fn recalled(&self, team: &RobotTeam, record: &Record) -> Movement {
        let _ = team;
        Movement::InCells(record.outcome.into())
    }

    /// What is done at the deadline: on along the route that was announced, if that may be, or nothing. `visits` are those of the
    /// state, and the policy is that of the planner in command, if it may be followed.
    fn fallback(
        &self,
        team: &RobotTeam,
        terrain: &Terrain,
        robot: RobotId,
        visits: u64,
        policy: Option<&Policy>,
    ) -> Fallback {
        let _ = (visits, policy);
        if let Some(action) = team.body(robot).along_route()
            && team.refusal_of(terrain, robot, action).is_none()
        {
            return Fallback { action, origin: Origin::Policy };
        }
        Fallback { action: Action::Hold, origin: Origin::Hold }
    }
}

/// What a robot that stays in its cell has come to: it takes no time.
fn stays(team: &RobotTeam, robot: RobotId, branch: Branch) -> Outcome {
    let from = team.roster.entry(robot).at.cell;
    Outcome { branch, from, to: from, flight: Flight::default() }
}

/// Why a robot that goes from point to point shall not announce a route, if there is a reason.
fn refusal_of_route(team: &RobotTeam, robot: RobotId, route: RouteId) -> Option<Refusal> {
    team.travels.refusal_of_route(team.body(robot), robot, route, |at| team.is_on_map(at))
}

/// What any action but a drive comes to of a robot that goes from point to point.
fn flight(team: &RobotTeam, robot: RobotId, action: Action) -> Movement {
    let arrival = team.travels.flight(&team.roster, robot, action, |at| team.cell_of(at));
    Movement::BetweenPoints(arrival, None)
}
