//! The other robots of a mission, as a planner has to reckon with them: where they are in the way, and whether to wait for one.

use contract::{Action, Brief, Cell, Member, Robot, Standing, Team};

/// Cells where robots other than the one that decides take up ground, except its own.
pub(crate) fn taken<'a>(brief: &'a Brief, team: &'a Team) -> impl Iterator<Item = Cell> + 'a {
    let here = team.member(team.due).map(|due| due.at.cell);
    let cells = others(brief, team).filter_map(|other| on_ground(brief, other));
    cells.filter(move |cell| Some(*cell) != here)
}

/// The cells of robots that act no more.
pub(crate) fn stopped<'a>(brief: &'a Brief, team: &'a Team) -> impl Iterator<Item = Cell> + 'a {
    others(brief, team)
        .filter(|(_, other)| other.standing != Standing::Active)
        .filter_map(|other| on_ground(brief, other))
}

/// Where hoppers go that still act.
pub(crate) fn goals<'a>(brief: &'a Brief, team: &'a Team) -> impl Iterator<Item = Cell> + 'a {
    let active = others(brief, team).filter(|(_, other)| other.standing == Standing::Active);
    active.filter_map(|(robot, _)| goal_of_hops(brief, robot))
}

/// Where a robot goes, if it is a hopper.
pub(crate) fn goal_of_hops(brief: &Brief, robot: &Robot) -> Option<Cell> {
    if robot.body.hops() { robot.goal.cell(&brief.grid, 0) } else { None }
}

/// A robot other than the one that decides that takes up `cell`.
pub(crate) fn occupant<'a>(brief: &'a Brief, team: &'a Team, cell: Cell) -> Option<&'a Member> {
    let mut others = others(brief, team);
    others.find(|other| on_ground(brief, *other) == Some(cell)).map(|(_, member)| member)
}

/// What a robot does that can go on only once others have acted: it waits for them, or holds as the last one that can act, since
/// waiting would end the mission then.
pub(crate) fn wait_or_hold(team: &Team) -> Action {
    let due = usize::from(team.due.0);
    let is_ready = |(number, other): (usize, &Member)| {
        number != due && other.standing == Standing::Active && !other.waits
    };
    if team.members.iter().enumerate().any(is_ready) { Action::Wait } else { Action::Hold }
}

/// All robots but the one that decides.
pub(crate) fn others<'a>(
    brief: &'a Brief,
    team: &'a Team,
) -> impl Iterator<Item = (&'a Robot, &'a Member)> + 'a {
    let numbered = brief.robots.numbered().zip(team.members.iter());
    let others = numbered.filter(|((number, _), _)| *number != team.due);
    others.map(|((_, robot), member)| (robot, member))
}

fn on_ground(brief: &Brief, (robot, member): (&Robot, &Member)) -> Option<Cell> {
    let stands = robot.body.is_on_ground() && brief.grid.contains(member.at.cell);
    stands.then_some(member.at.cell)
}
