//! When each goal is reached.
//!
//! Each goal is a file that implements [`Goal`] for the parameters of the brief, and a line in the list below.

use contract::{RobotId, Status};
use terrain::Terrain;

use super::RobotTeam;

/// How the goal of a robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// It may still be reached.
    Open,
    /// It is reached.
    Done,
    /// It cannot be reached any more, which ends a mission that needs it.
    Failed(Status),
}

/// The rules of one goal.
pub trait Goal {
    /// Whether `robot`, which is active, has reached it, and stays where it is from now on. `steps` are those of the hopper, where the
    /// mission counts them.
    fn is_reached(&self, team: &RobotTeam, terrain: &Terrain, robot: RobotId, steps: u64) -> bool {
        let _ = (team, terrain, robot, steps);
        false
    }

    /// How it stands for all robots that have it, if they reach it together; `None` if each reaches it on its own.
    fn common_part(&self, team: &RobotTeam) -> Option<Part> {
        let _ = team;
        None
    }
}

contract::rules! {
    /// The rules of a goal.
    pub fn of(Goal) -> Goal;
    cover => Cover,
    look_ahead => LookAhead,
    reach => Reach,
    visit => Visit,
}
