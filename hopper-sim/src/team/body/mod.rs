//! What each body may do, and what its actions come to.

mod driver;
mod helicopter;
mod hopper;
mod rover;

use ::rover::Drive;
use contract::{Action, Branch, Flight, Origin, Outcome, Policy, Record, Refusal, RobotId, Vehicle};
use terrain::Terrain;

use super::RobotTeam;
use super::travels::Arrival;
use crate::Mission;
use crate::guard::Fallback;

/// A decision of a robot: what it does, and under whom.
pub use super::roster::Act;

/// What an action has come to.
#[derive(Clone, Debug)]
pub enum Deed {
    /// Of a robot that goes from cell to cell.
    InCells(Outcome),
    /// Of one that goes from point to point, with the drive, if it was one.
    OnWay(Arrival, Option<Drive>),
}

impl Deed {
    /// As it is recorded.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        match self {
            Deed::InCells(outcome) => *outcome,
            Deed::OnWay(arrival, _) => arrival.outcome,
        }
    }
}

/// The actions of robots of one kind.
pub trait Body {
    /// Why `robot`, which is due, shall not execute `action`, if there is a reason.
    fn refusal(&self, team: &RobotTeam, terrain: &Terrain, robot: RobotId, action: Action)
    -> Option<Refusal>;

    /// What an action comes to that was not refused, drawn on the true ground.
    fn deed(&self, team: &RobotTeam, mission: &Mission, act: &Act) -> Deed;

    /// What an action of an earlier life has come to.
    fn recalled(&self, team: &RobotTeam, record: &Record) -> Deed {
        let _ = team;
        Deed::InCells(record.outcome)
    }

    /// What is done at the deadline; `visits` are those of the state, and the policy is that of the planner in command, if it
    /// may be followed.
    fn fallback(
        &self,
        team: &RobotTeam,
        terrain: &Terrain,
        robot: RobotId,
        visits: u64,
        policy: Option<&Policy>,
    ) -> Fallback;
}

/// The body of a vehicle.
#[must_use]
pub fn of(vehicle: Vehicle) -> &'static dyn Body {
    match vehicle {
        Vehicle::Hopper | Vehicle::HopperTo { .. } => &hopper::Hopper,
        Vehicle::Rover { .. } => &rover::Rover,
        Vehicle::Driver { .. } => &driver::Driver,
        Vehicle::Helicopter { .. } => &helicopter::Helicopter,
    }
}

/// It stays where it is.
#[must_use]
pub fn hold() -> Fallback {
    Fallback { action: Action::Hold, origin: Origin::Hold }
}

/// It goes on along the route that it has announced, if it may.
fn along_route(team: &RobotTeam, terrain: &Terrain, robot: RobotId, action: Action) -> Fallback {
    if team.refusal_of(terrain, robot, action).is_none() {
        Fallback { action, origin: Origin::Policy }
    } else {
        hold()
    }
}

/// It waits in its cell, which takes no time.
fn waits(team: &RobotTeam, robot: RobotId) -> Outcome {
    let from = team.roster.entry(robot).at.cell;
    Outcome { branch: Branch::Held, from, to: from, flight: Flight::default() }
}
