//! A point is reached in its cell, or within its radius by a robot that goes from point to point and goes no further.

use contract::{Account, Reach, RobotId};
use terrain::Terrain;

use super::Goal;
use crate::team::RobotTeam;
use crate::team::travels::START_TOLERANCE_M;

impl Goal for Reach {
    fn is_reached(&self, team: &RobotTeam, _: &Terrain, robot: RobotId, steps: u64) -> bool {
        let brief = &team.brief;
        match team.travels.get(robot) {
            Some(travel) => {
                let is_near = travel.at.distance_m(self.at) <= self.radius_m + START_TOLERANCE_M;
                is_near && !travel.is_under_way()
            }
            None => {
                let in_time = brief.account != Account::Hopper || steps <= brief.limits.steps_max;
                team.roster.entry(robot).at.cell == self.at.cell_of(&brief.grid) && in_time
            }
        }
    }
}
