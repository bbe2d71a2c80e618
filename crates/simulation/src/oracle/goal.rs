//! What the oracle asks of a goal. Each goal is a file of the folder `goal` that implements it for the parameters of the brief, and a
//! line in the list below.

use contract::{Cell, Cover, Grid, Robot};

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

    /// What is to be covered, if that is the goal. All robots that cover ground have reached it together, once it is covered.
    fn cover(&self) -> Option<Cover> {
        None
    }
}

/// Declares the module of each goal, and how its rules are found.
macro_rules! goals {
    ($($module:ident => $name:ident,)+) => {
        $(mod $module;)+

        /// The rules of a robot's goal.
        pub(super) fn of(robot: &Robot) -> &dyn Goal {
            match &robot.goal {
                $(contract::Goal::$name(goal) => goal,)+
            }
        }
    };
}

goals! {
    cover => Cover,
    look_ahead => LookAhead,
    reach => Reach,
    visit => Visit,
}

impl Actor {
    /// The rules of its goal.
    pub fn goal(&self) -> &dyn Goal {
        of(&self.robot)
    }

    /// Whether it covers ground.
    pub fn covers(&self) -> bool {
        self.goal().cover().is_some()
    }
}
