//! Where the robots of a mission are to go.

use contract::{Brief, Cell, Goal, Grid, Robot, RobotId, Waypoint};

/// The only robot with a goal, if that goal is a place and all others look ahead; `None` where several robots have goals, or ground
/// is to be covered.
#[must_use]
pub fn with_only_goal(brief: &Brief) -> Option<(RobotId, &Robot)> {
    let mut with_goals =
        brief.robots.numbered().filter(|(_, robot)| !matches!(robot.goal, Goal::LookAhead(_)));
    match (with_goals.next(), with_goals.next()) {
        (Some(only), None) if only.1.goal.cell(&brief.grid, 0).is_some() => Some(only),
        _ => None,
    }
}

/// The cells of a goal in the order in which they are visited; none if the goal is no place.
#[must_use]
pub fn goal_cells(goal: &Goal, grid: &Grid) -> Vec<Cell> {
    match goal {
        Goal::Reach(reach) => vec![reach.at.cell_of(grid)],
        Goal::Visit(visit) => visit.goals().to_vec(),
        Goal::Cover(_) | Goal::LookAhead(_) => Vec::new(),
    }
}

/// As [`goal_cells`], as points: the middle of each cell, but of a goal that is a point this point.
#[must_use]
pub fn goal_points(goal: &Goal, grid: &Grid) -> Vec<Waypoint> {
    match goal {
        Goal::Reach(reach) => vec![reach.at],
        _ => goal_cells(goal, grid).into_iter().map(|cell| Waypoint::middle_of(grid, cell)).collect(),
    }
}
