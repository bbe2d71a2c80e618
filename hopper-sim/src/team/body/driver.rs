//! A rover with a goal announces a route and drives to its points one after the other, over ground of uncertain speed.
//!
//! A drive takes what the true speeds make of it and ends at the border of a cell of speed 0, where the rover is stranded for
//! good. In all stages but the last the rover drives for a Sol at most. The drive that uses it up ends there, on the way
//! ([`Branch::Halted`]), and the next stage begins.
//!
//! The guard asks for the kind of the action, for a robot that stands where the drive would end, and for the largest
//! probability of getting stuck along it as far as anybody can know it: by the prior, or by what the sensors have shown of a
//! cell. That the rover gets stuck where another robot stands is not refused, since nobody chooses it.

use ::rover::{DriveEnd, SOL_HOURS};
use contract::{Action, Branch, Driver, Record, Refusal, RobotId, Waypoint};
use terrain::Terrain;

use super::{Act, Body, Movement, flight, refusal_of_route};
use crate::Mission;
use crate::team::RobotTeam;
use crate::team::travels::Arrival;

impl Body for Driver {
    fn refusal(&self, team: &RobotTeam, _: &Terrain, robot: RobotId, action: Action) -> Option<Refusal> {
        let needs = |need: &str| Some(Refusal::malformed("command.action", need, action));
        match action {
            Action::Hold | Action::Wait | Action::Done => None,
            Action::Announce(id) => refusal_of_route(team, robot, id),
            Action::Drive => {
                let (ground, travel) = (team.ground.as_ref()?, team.travels.get(robot)?);
                let Some(to) = team.travels.next(travel) else {
                    return needs("an announced route with a point to go to");
                };
                let cell = team.cell_of(to);
                match team.roster.other_on_ground(robot, cell) {
                    Some(robot) => Some(Refusal::Occupied { action, cell, robot }),
                    None => {
                        let (need, got) = (team.brief.guard.hazard_max, ground.hazard(travel.at, to));
                        (got > need).then_some(Refusal::Vetoed { action, need, got })
                    }
                }
            }
            _ => needs("drive, announce, wait, done or hold: the robot is a rover on uncertain ground"),
        }
    }

    fn movement(&self, team: &RobotTeam, _: &Mission, act: &Act) -> Movement {
        drive(team, act.robot, act.action)
    }

    fn recalled(&self, team: &RobotTeam, record: &Record) -> Movement {
        drive(team, record.robot, record.action)
    }
}

/// What an action comes to: a drive to the next point of the route, or one that is no drive or fails.
fn drive(team: &RobotTeam, robot: RobotId, action: Action) -> Movement {
    let goes = action == Action::Drive && !team.roster.fails_now(robot);
    if let (true, Some(ground), Some(travel)) = (goes, &team.ground, team.travels.get(robot))
        && let Some(to) = team.travels.next(travel)
    {
        let drive = ground.drive(robot, travel.at, to);
        let at = Waypoint { x_m: drive.at.x_m, y_m: drive.at.y_m };
        let branch = match drive.end {
            DriveEnd::Stuck { .. } => Branch::Stranded,
            DriveEnd::Arrived => Branch::Intended,
            DriveEnd::OutOfTime => Branch::Halted,
        };
        let cells = [team.roster.entry(robot).at.cell, team.cell_of(at)];
        let seconds = drive.duration_sol * SOL_HOURS * 3600.0;
        return Movement::BetweenPoints(
            Arrival::goes(cells, at, branch, drive.length_m, seconds),
            Some(drive),
        );
    }
    flight(team, robot, action)
}
