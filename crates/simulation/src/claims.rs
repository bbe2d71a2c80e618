//! Turns that planners owe: who is told to take over asks for the next term of each robot that it serves.

use std::collections::BTreeMap;

use contract::{Incarnation, RobotId};

/// Turns of a robot that may pass before its new planner asks for one, though it sits idle: it may wake late.
const PASSED_MAX: u64 = 8;

/// Of each life and robot, how many turns have passed that it could have asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Claims(BTreeMap<(Incarnation, RobotId), u64>);

impl Claims {
    /// A life is told to take over these robots.
    pub fn begin(&mut self, who: Incarnation, robots: &[RobotId]) {
        self.0.extend(robots.iter().map(|robot| ((who, *robot), 0)));
    }

    /// A life has sent a command for a robot.
    pub fn settle(&mut self, who: Incarnation, robot: RobotId) {
        self.0.remove(&(who, robot));
    }

    /// Whether a life still has to ask for the turn of a robot.
    pub fn is_owed(&self, who: Incarnation, robot: RobotId) -> bool {
        self.0.contains_key(&(who, robot))
    }

    /// A turn of a robot was another's though a life, which owes it, sat idle; whether that was once too often.
    pub fn pass(&mut self, who: Incarnation, robot: RobotId) -> bool {
        let Some(passed) = self.0.get_mut(&(who, robot)) else { return false };
        *passed += 1;
        *passed > PASSED_MAX
    }
}
