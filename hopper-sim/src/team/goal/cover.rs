//! Ground is covered by all robots together. Who has nothing left to cover is done: `Coverage` sees to that.

use contract::{Cover, Status};

use super::{Goal, Part};
use crate::team::RobotTeam;

impl Goal for Cover {
    fn common_part(&self, team: &RobotTeam) -> Option<Part> {
        let coverage = team.coverage.as_ref()?;
        Some(if coverage.is_covered() {
            Part::Done
        } else if coverage.is_at_work(&team.roster) {
            Part::Open
        } else {
            Part::Failed(Status::Lost)
        })
    }
}
