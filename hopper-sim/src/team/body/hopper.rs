//! A hopper hops to one of four cells at a time, by the law of motion.
//!
//! What is too dangerous the guard vetoes. A hop that would stray onto another robot on the ground ends where it began, so that
//! all landings are whole hops apart. A hopper that fails stays where it is.

use contract::{Account, Action, Branch, Cell, Flight, Hopper, Outcome, Policy, Pose, Refusal, RobotId};
use terrain::Terrain;

use super::{Act, Body, Movement, waits};
use crate::Mission;
use crate::dynamics::outcome_of_hop;
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
            _ => {
                let need = if may_wait { "a hop, wait or hold" } else { "a hop or hold" };
                let need = format!("{need}: the robot is a hopper");
                return Some(Refusal::malformed("command.action", &need, action));
            }
        }
        if let Some(refusal) = occupied(team, robot, action) {
            return Some(refusal);
        }
        let need = team.brief.guard.hazard_max;
        guard(team, terrain, robot).veto(action).map(|got| Refusal::Vetoed { action, need, got })
    }

    fn movement(&self, team: &RobotTeam, mission: &Mission, act: &Act) -> Movement {
        let Act { robot, decision, action, .. } = *act;
        let from = team.roster.entry(robot).at.cell;
        Movement::InCells(if team.roster.fails_now(robot) {
            Outcome { branch: Branch::Stranded, from, to: from, flight: Flight::default() }
        } else if action == Action::Wait {
            waits(team, robot)
        } else {
            let outcome = outcome_of_hop(mission, robot, decision, from, action);
            match occupant(team, robot, outcome.to) {
                Some(_) => Outcome { to: from, ..outcome },
                None => outcome,
            }
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
    let Action::Hop(direction) = action else { return None };
    let cell = team.brief.grid.hop(team.roster.entry(robot).at.cell, direction);
    occupant(team, robot, cell).map(|robot| Refusal::Occupied { action, cell, robot })
}

/// Another robot that takes up `cell` of the map.
fn occupant(team: &RobotTeam, robot: RobotId, cell: Cell) -> Option<RobotId> {
    if team.brief.grid.contains(cell) { team.roster.other_on_ground(robot, cell) } else { None }
}
