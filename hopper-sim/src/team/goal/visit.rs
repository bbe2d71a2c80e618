//! Visits in turn end with a count of decisions.

use contract::{RobotId, Visit};
use terrain::Terrain;

use super::Goal;
use crate::team::RobotTeam;

impl Goal for Visit {
    fn is_reached(&self, team: &RobotTeam, _: &Terrain, robot: RobotId, _: u64) -> bool {
        team.roster.actions(robot) >= self.hops_max
    }
}
