//! What the oracle asks of a goal. Each goal is a file of the folder `goal` that implements it for the parameters of the brief, and a
//! line in the list below.

use contract::{Cell, Grid};

use super::Oracle;
use super::actor::Actor;

/// Where robots of one goal go, and when they have reached it. `number` is that of the robot.
pub(super) trait Goal {
    /// The cell to which it is to go after so many visits, if it goes to cells that are known before the mission.
    fn cell(&self, _grid: &Grid, _visits: u64) -> Option<Cell> {
        None
    }

    /// The cell to which it is to go after so many visits, by what robots have seen.
    fn cell_by(&self, oracle: &Oracle, _number: usize, visits: u64) -> Option<Cell> {
        self.cell(&oracle.mission.brief.grid, visits)
    }

    /// The cell that it has visited last.
    fn last(&self, _visits: u64) -> Option<Cell> {
        None
    }

    /// Whether a robot that still acts has reached it.
    fn is_reached(&self, _oracle: &Oracle, _number: usize, _steps: u64) -> bool {
        false
    }
}

contract::rules! {
    /// The rules of a goal.
    pub(super) fn of(Goal) -> Goal;
    cover => Cover,
    look_ahead => LookAhead,
    reach => Reach,
    visit => Visit,
}

impl Actor {
    /// The rules of its goal.
    pub fn goal(&self) -> &dyn Goal {
        of(&self.robot.goal)
    }

    /// Whether it covers ground.
    pub fn covers(&self) -> bool {
        self.robot.goal.cover().is_some()
    }
}
