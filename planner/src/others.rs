//! The other robots of a mission, as a planner has to reckon with them: where they are in the way, and whether to wait for one.

use contract::{Action, Cell, Grid, Member, Standing, Team};

/// Cells where robots other than the one that decides take up ground, except its own.
pub(crate) fn taken<'a>(team: &'a Team, grid: &'a Grid) -> impl Iterator<Item = Cell> + 'a {
    let here = team.member(team.due).map(|due| due.at.cell);
    others(team).filter_map(move |other| on_ground(other, grid)).filter(move |cell| Some(*cell) != here)
}

/// The cells of robots that act no more.
pub(crate) fn stopped<'a>(team: &'a Team, grid: &'a Grid) -> impl Iterator<Item = Cell> + 'a {
    others(team)
        .filter(|other| other.standing != Standing::Active)
        .filter_map(move |other| on_ground(other, grid))
}

/// Where hoppers go that still act.
pub(crate) fn goals(team: &Team) -> impl Iterator<Item = Cell> + '_ {
    let active = others(team).filter(|other| other.standing == Standing::Active);
    active.filter_map(|other| other.robot.vehicle.hop_goal())
}

/// A robot other than the one that decides that takes up `cell`.
pub(crate) fn occupant<'a>(team: &'a Team, grid: &Grid, cell: Cell) -> Option<&'a Member> {
    others(team).find(|other| on_ground(other, grid) == Some(cell))
}

/// What a robot does that can go on only once others have acted: it waits for them, or holds as the last one that can act, since
/// waiting would end the mission then.
pub(crate) fn wait_or_hold(team: &Team) -> Action {
    let is_ready = |other: &Member| other.standing == Standing::Active && !other.waits;
    if others(team).any(is_ready) { Action::Wait } else { Action::Hold }
}

/// All robots but the one that decides.
pub(crate) fn others(team: &Team) -> impl Iterator<Item = &Member> {
    let due = usize::from(team.due.0);
    team.members.iter().enumerate().filter(move |(number, _)| *number != due).map(|(_, member)| member)
}

fn on_ground(member: &Member, grid: &Grid) -> Option<Cell> {
    let stands = member.robot.vehicle.is_on_ground() && grid.contains(member.at.cell);
    stands.then_some(member.at.cell)
}
