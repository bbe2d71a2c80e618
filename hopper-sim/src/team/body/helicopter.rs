//! A helicopter announces a route and flies to its points one after the other, above all others.
//!
//! A flight takes its length divided by the speed; to announce and to hold take a second, to wait and to be done no time. The
//! guard asks for the kind of the action, the length of the route and the flight budget.

use contract::{Action, Policy, Record, Refusal, RobotId};
use terrain::Terrain;

use super::{Act, Body, Deed, along_route};
use crate::Mission;
use crate::guard::Fallback;
use crate::team::RobotTeam;

/// Helicopters.
#[derive(Clone, Copy, Debug)]
pub struct Helicopter;

impl Body for Helicopter {
    fn refusal(&self, team: &RobotTeam, _: &Terrain, robot: RobotId, action: Action) -> Option<Refusal> {
        let vehicle = team.roster.entry(robot).robot.vehicle;
        match action {
            Action::Announce(id) => {
                team.travels.refusal_of_route(vehicle, robot, id, |at| team.is_on_map(at))
            }
            _ => team.travels.refusal_of_flight(vehicle, robot, action),
        }
    }

    fn deed(&self, team: &RobotTeam, _: &Mission, act: &Act) -> Deed {
        flight(team, act.robot, act.action)
    }

    fn recalled(&self, team: &RobotTeam, record: &Record) -> Deed {
        flight(team, record.robot, record.action)
    }

    fn fallback(
        &self,
        team: &RobotTeam,
        terrain: &Terrain,
        robot: RobotId,
        _: u64,
        _: Option<&Policy>,
    ) -> Fallback {
        along_route(team, terrain, robot, Action::Fly)
    }
}

fn flight(team: &RobotTeam, robot: RobotId, action: Action) -> Deed {
    Deed::OnWay(team.travels.flight(&team.roster, robot, action, |at| team.cell_of(at)), None)
}
