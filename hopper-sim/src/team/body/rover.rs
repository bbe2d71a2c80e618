//! A rover that covers ground drives to one of the four neighbouring cells at a time.
//!
//! A step ends where it was meant to, whatever the ground, since all others are refused: a rover drives to a free cell that no
//! other robot stands on and that is no hopper's goal. What a step takes is its way divided by the rover's speed; to hold takes
//! a second. A rover that fails stays where it is for good and still occupies its cell.

use contract::{Action, Branch, Cell, Direction, Flight, Outcome, Refusal, RobotId, Rover};
use terrain::Terrain;

use super::{Act, Body, Movement, stays};
use crate::Mission;
use crate::team::RobotTeam;
use crate::team::coverage::is_free;

impl Body for Rover {
    fn refusal(
        &self,
        team: &RobotTeam,
        terrain: &Terrain,
        robot: RobotId,
        action: Action,
    ) -> Option<Refusal> {
        match action {
            Action::Hold | Action::Wait => None,
            Action::Step(direction) => {
                let to = beside(team.roster.entry(robot).at.cell, direction);
                let is_kept = team.coverage.as_ref().is_some_and(|coverage| coverage.keeps(to));
                let vetoed = Refusal::Vetoed { action, need: 0.0, got: 1.0 };
                match team.roster.other_on_ground(robot, to) {
                    Some(robot) => Some(Refusal::Occupied { action, cell: to, robot }),
                    None => (!is_free(terrain, to) || is_kept).then_some(vetoed),
                }
            }
            _ => {
                let need = "a step, wait or hold: the robot is a rover";
                Some(Refusal::malformed("command.action", need, action))
            }
        }
    }

    fn movement(&self, team: &RobotTeam, mission: &Mission, act: &Act) -> Movement {
        let Act { robot, action, .. } = *act;
        let from = team.roster.entry(robot).at.cell;
        let stays_a_second = |branch| {
            let flight = Flight { flight_time_s: 1.0, flights: 1, ..Flight::default() };
            Outcome { branch, from, to: from, flight }
        };
        let outcome = match action {
            _ if team.roster.fails_now(robot) => stays_a_second(Branch::Stranded),
            Action::Step(direction) => {
                let terrain = &mission.terrain;
                let to = beside(from, direction);
                let height_m = |cell| terrain.ground(cell).map_or(0.0, |ground| ground.height_m);
                let (range_m, rise_m) = (terrain.grid.cell_size_m, height_m(to) - height_m(from));
                let flight_time_s = libm::hypot(range_m, rise_m) / self.speed_mps;
                let flight = Flight { range_m, rise_m, flight_time_s, flights: 1, ..Flight::default() };
                Outcome { branch: Branch::Intended, from, to, flight }
            }
            Action::Wait => stays(team, robot, Branch::Held),
            _ => stays_a_second(Branch::Held),
        };
        Movement::InCells(outcome.into())
    }
}

fn beside(cell: Cell, direction: Direction) -> Cell {
    let (dx, dy) = direction.step();
    Cell::new(cell.x + dx, cell.y + dy)
}
