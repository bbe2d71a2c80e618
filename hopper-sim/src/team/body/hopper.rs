//! A hopper hops to one of four cells at a time, by the motion model of the mission.
//!
//! What is too dangerous the guard vetoes. A hop that would stray onto another robot on the ground ends where it began, so that
//! all landings are whole hops apart. A hopper that fails stays where it is.

use contract::{Account, Action, Branch, Cell, Detail, Hopper, Policy, Pose, Refusal, RobotId};
use terrain::Terrain;

use super::{Act, Body, Movement, stays};
use crate::Mission;
use crate::dynamics::{Hop, Landing};
use crate::guard::{Fallback, Guard};
use crate::team::RobotTeam;

impl Body for Hopper {
    fn refusal(
        &self,
        team: &RobotTeam,
        terrain: &Terrain,
        robot: RobotId,
        action: Action,
    ) -> Option<Refusal> {
        // A hopper whose steps alone are counted has nobody to wait for.
        let may_wait = team.brief.account != Account::Hopper;
        match action {
            Action::Wait if may_wait => return None,
            Action::Hold | Action::Hop(_) => {}
            Action::Up(_) if self.motion.vertical => {}
            _ => {
                let need = if may_wait { "a hop, wait or hold" } else { "a hop or hold" };
                let need = format!("{need}: the robot is a hopper");
                return Some(Refusal::malformed("command.action", &need, action));
            }
        }
        if let Some(refusal) = occupied(team, robot, action) {
            return Some(refusal);
        }
        guard(team, terrain, robot).refusal(action)
    }

    fn movement(&self, team: &RobotTeam, mission: &Mission, act: &Act) -> Movement {
        let Act { robot, decision, action, .. } = *act;
        let from = team.roster.entry(robot).at.cell;
        let direction = match action.hop() {
            Some(direction) if !team.roster.fails_now(robot) => direction,
            _ => {
                let fails = team.roster.fails_now(robot);
                let branch = if fails { Branch::Stranded } else { Branch::Held };
                let detail = team.detail(robot).map(Detail::at_rest);
                return Movement::InCells(Landing { outcome: stays(team, robot, branch), detail });
            }
        };
        let rest_m = team.detail(robot).map(|detail| detail.rest_m);
        let is_up = matches!(action, Action::Up(_));
        let hop = Hop { mission, robot, body: self, decision, from, rest_m, direction, is_up };
        let landing = team.model.hop(&hop);
        let is_taken = |cell| occupant(team, robot, cell).is_some();
        Movement::InCells(if is_taken(landing.outcome.to) {
            team.model.displaced(&hop, landing, &is_taken)
        } else {
            landing
        })
    }

    fn fallback(
        &self,
        team: &RobotTeam,
        terrain: &Terrain,
        robot: RobotId,
        visits: u64,
        policy: Option<&Policy>,
    ) -> Fallback {
        let entry = team.roster.entry(robot);
        let goal = entry.robot.goal.cell(&team.brief.grid, visits).unwrap_or(entry.at.cell);
        let may = |action| occupied(team, robot, action).is_none();
        guard(team, terrain, robot).fallback(goal, policy, may)
    }
}

/// The guard where the hopper stands.
fn guard<'a>(team: &'a RobotTeam, terrain: &'a Terrain, robot: RobotId) -> Guard<'a> {
    let cell = team.roster.entry(robot).at.cell;
    let height_m = terrain.ground(cell).map_or(0.0, |ground| ground.height_m);
    Guard::new(&team.brief, terrain, robot, Pose { cell, height_m })
}

/// That another robot is where a hop aims, if one is.
fn occupied(team: &RobotTeam, robot: RobotId, action: Action) -> Option<Refusal> {
    let direction = action.hop()?;
    let cell = team.brief.grid.hop(team.roster.entry(robot).at.cell, direction);
    occupant(team, robot, cell).map(|robot| Refusal::Occupied { action, cell, robot })
}

/// Another robot that takes up `cell` of the map.
fn occupant(team: &RobotTeam, robot: RobotId, cell: Cell) -> Option<RobotId> {
    if team.brief.grid.contains(cell) { team.roster.other_on_ground(robot, cell) } else { None }
}
