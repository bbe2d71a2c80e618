//! Where the robots of a mission are to go.

use contract::{Brief, Cell, Goal, Grid, Robot, RobotId};

/// The robot that alone goes to places, while all others look ahead for it; `None` where several robots have goals, or ground is
/// to be covered.
#[must_use]
pub fn with_only_goal(brief: &Brief) -> Option<(RobotId, &Robot)> {
    let mut with_goals =
        brief.robots.numbered().filter(|(_, robot)| !matches!(robot.goal, Goal::LookAhead(_)));
    match (with_goals.next(), with_goals.next()) {
        (Some(only), None) if only.1.goal.cell(&brief.grid, 0).is_some() => Some(only),
        _ => None,
    }
}

/// The cells of a goal in the order in which they are visited; none where there are no places to go to.
#[must_use]
pub fn goal_cells(goal: &Goal, grid: &Grid) -> Vec<Cell> {
    match goal {
        Goal::Reach(reach) => vec![reach.at.cell_of(grid)],
        Goal::Visit(visit) => visit.goals().to_vec(),
        Goal::Cover(_) | Goal::LookAhead(_) => Vec::new(),
    }
}
