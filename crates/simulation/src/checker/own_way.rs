//! The ways of hoppers that have goals of their own.

use contract::{Action, Cell, Design, Direction, Origin, RobotId};
use planner::Situation;

use super::Checker;
use crate::expected::design;
use crate::robots::Robots;

impl Checker {
    /// The robots of a mission in which each has a task of its own.
    pub(crate) fn mixed(&self) -> Option<&Robots> {
        if self.mission.brief.mixed.is_some() { Some(&self.robots) } else { None }
    }

    /// Start, goal and place of the hopper that is due, if it has a goal of its own.
    fn own_way(&self) -> Option<[Cell; 3]> {
        self.mixed().and_then(Robots::own_way)
    }

    /// Whether a hopper is due that has a goal of its own.
    pub(super) fn is_turn_of_own_way(&self) -> bool {
        self.own_way().is_some()
    }

    /// What such a hopper does at the deadline: the hop that nothing speaks against and whose aim is nearest to its goal, of equals
    /// the first of north, east, south and west.
    pub(super) fn greedy_on_own_way(&self) -> Option<(Action, Origin)> {
        let [_, goal, at] = self.own_way()?;
        let to_veto = self.to_veto(at);
        let grid = self.mission.brief.grid;
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
        let Some([start, goal, at]) = self.own_way() else { return };
        let (brief, state) = (situation.brief, situation.state);
        let height_m = self.mission.terrain.ground(at).map(|ground| ground.height_m);
        let due = self.mixed().and_then(Robots::due).unwrap_or(RobotId(0));
        let is_own = (brief.start, brief.goal) == (start, goal)
            && design(&self.mission.brief, due) == (Design { motion: brief.motion, sensor: brief.sensor })
            && state.pose.cell == at
            && Some(state.pose.height_m) == height_m;
        self.require(is_own, "a hopper's planner is given its own way", || {
            let (from, to, pose) = (brief.start, brief.goal, state.pose.cell);
            format!("from {from} to {to} at {pose}, needs from {start} to {goal} at {at}")
        });
    }
}
