//! A helicopter announces a route and flies to its points one after the other, above all others.
//!
//! A flight takes its length divided by the speed; to announce and to hold take a second, to wait and to be done no time. The
//! guard asks for the kind of the action, the length of the route and the flight budget.

use contract::{Action, Helicopter, Record, Refusal, RobotId};
use terrain::Terrain;

use super::{Act, Body, Movement, flight, refusal_of_route};
use crate::Mission;
use crate::team::RobotTeam;

impl Body for Helicopter {
    fn refusal(&self, team: &RobotTeam, _: &Terrain, robot: RobotId, action: Action) -> Option<Refusal> {
        match action {
            Action::Announce(id) => refusal_of_route(team, robot, id),
            _ => team.travels.refusal_of_flight(team.body(robot), robot, action),
        }
    }

    fn movement(&self, team: &RobotTeam, _: &Mission, act: &Act) -> Movement {
        flight(team, act.robot, act.action)
    }

    fn recalled(&self, team: &RobotTeam, record: &Record) -> Movement {
        flight(team, record.robot, record.action)
    }
}
