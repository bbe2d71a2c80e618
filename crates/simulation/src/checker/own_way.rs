//! The ways of hoppers, each to a goal of its own.

use contract::{Account, Action, Cell, Direction, Goal, Origin};
use planner::Situation;

use super::Checker;
use crate::expected::goal_cell;
use crate::robots::Robots;

impl Checker {
    /// All robots after the records so far.
    pub(crate) fn robots(&self) -> &Robots {
        &self.robots
    }

    /// What a hopper does at the deadline, unless it is the one that the mission is about, which may follow a policy: the hop that
    /// nothing speaks against and whose aim is nearest to its goal, of equals the first of north, east, south and west.
    pub(super) fn greedy_on_own_way(&self) -> Option<(Action, Origin)> {
        let grid = self.mission.brief.grid;
        let hopper = self.robots.due_hopper().filter(|_| self.mission.brief.account != Account::Hopper)?;
        let (goal, at) = (goal_cell(&grid, &hopper.robot, 0)?, hopper.cell);
        let to_veto = self.to_veto();
        let is_passable = |cell: Cell| {
            let index = grid.contains(cell).then(|| grid.index(cell)).flatten();
            index.is_some_and(|index| self.maps.expected.cells()[index].is_none_or(|ground| ground.passable))
        };
        let aim = |direction: &Direction| grid.hop(at, *direction);
        let is_open =
            |direction: &Direction| !to_veto.has(Action::Hop(*direction)) && is_passable(aim(direction));
        let away = |direction: &Direction| {
            let aim = aim(direction);
            (aim.x - goal.x).pow(2) + (aim.y - goal.y).pow(2)
        };
        let nearest = Direction::ALL.into_iter().filter(is_open).min_by_key(away);
        Some(
            nearest
                .map_or((Action::Hold, Origin::Hold), |direction| (Action::Hop(direction), Origin::Greedy)),
        )
    }

    /// A planner is about to plan for the robot that is due.
    pub(super) fn plans_own_way(&mut self, situation: &Situation<'_>) {
        let (Some(hopper), state) = (self.robots.due_hopper(), situation.state) else { return };
        let (grid, robot, at) = (&self.mission.brief.grid, &hopper.robot, hopper.cell);
        let height_m = self.mission.terrain.ground(at).map(|ground| ground.height_m);
        // Elsewhere the visits of a state are those of all robots.
        let visits = if self.mission.brief.account == Account::Hopper { state.visits } else { 0 };
        let to = goal_cell(grid, robot, visits);
        let start = match robot.goal {
            Goal::Visit(_) if visits > 0 => goal_cell(grid, robot, visits - 1),
            Goal::Visit(_) | Goal::Reach(_) | Goal::Cover(_) | Goal::LookAhead(_) => Some(robot.start.cell),
        };
        let given = situation.leg.map(|leg| (leg.start, leg.goal));
        let hops = situation.leg.map(|leg| (&leg.motion, &leg.sensor));
        let is_own = given == start.zip(to)
            && hops == robot.as_hopper()
            && state.pose.cell == at
            && Some(state.pose.height_m) == height_m;
        self.require(is_own, "a hopper's planner is given its own way", || {
            format!("the way {given:?} at {}, needs {start:?} to {to:?} at {at}", state.pose.cell)
        });
    }
}
