//! Where the robots of a mission are to go.

use contract::{Brief, Robot, RobotId};

/// The only robot with a goal, if that goal is a place and all others look ahead; `None` where several robots have goals, or ground
/// is to be covered.
#[must_use]
pub fn with_only_goal(brief: &Brief) -> Option<(RobotId, &Robot)> {
    let mut with_goals = brief.robots.numbered().filter(|(_, robot)| !robot.goal.looks_ahead());
    match (with_goals.next(), with_goals.next()) {
        (Some(only), None) if only.1.goal.cell(&brief.grid, 0).is_some() => Some(only),
        _ => None,
    }
}
