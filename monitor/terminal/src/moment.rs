//! The mission when a decision was due.

use contract::{Brief, Cell, Decision, RobotId};
use monitor::History;
use monitor::history::Hop;

/// The hop before that moment.
pub(crate) fn hop_before(history: &History, at: Decision) -> Option<&Hop> {
    history.hops()?.get(Decision(at.0.checked_sub(1)?))
}

/// The goal of robot 0 in force when a decision was due; `None` if it has none.
pub(crate) fn goal(history: &History, brief: &Brief, at: Decision) -> Option<Cell> {
    brief.goal_after(hop_before(history, at).map_or(0, |hop| hop.visits))
}

pub(crate) fn pose(history: &History, at: Decision) -> Option<Cell> {
    let start = history.brief()?.robots[0].start.cell;
    Some(hop_before(history, at).map_or(start, |hop| hop.to))
}

/// Which of several robots something is about, as the beginning of a line.
pub(crate) fn robot_of(history: &History, robot: RobotId) -> String {
    if is_team(history) { format!("robot {robot}: ") } else { String::new() }
}

pub(crate) fn is_team(history: &History) -> bool {
    history.brief().is_some_and(|brief| brief.robots.count() > 1)
}
