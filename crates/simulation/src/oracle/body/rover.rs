//! A rover that steps from cell to cell, as it should be.

use contract::{Action, Branch, Cell, Decision, Direction, Flight, Outcome, Rover};
use hopper_sim::Mission;

use super::Body;
use crate::oracle::Oracle;
use crate::oracle::actor::Arrival;
use crate::oracle::covering::{index, is_free};
use crate::oracle::goals_of_hoppers;

impl Body for Rover {
    fn may(&self, _oracle: &Oracle, _number: usize, action: Action) -> bool {
        matches!(action, Action::Hold | Action::Wait | Action::Step(_))
    }

    fn is_blocked(&self, oracle: &Oracle, number: usize, action: Action) -> bool {
        let Some(to) = self.step_to(oracle.turns.actors[number].cell, action) else { return false };
        let is_kept = goals_of_hoppers(&oracle.mission).contains(&to);
        !is_free(&oracle.mission, to) || is_kept || oracle.is_occupied(number, to)
    }

    fn act(&self, oracle: &Oracle, number: usize, _decision: Decision, action: Action) -> Arrival {
        let (mission, actor) = (&oracle.mission, &oracle.turns.actors[number]);
        let still = Flight { flight_time_s: 1.0, flights: 1, ..Flight::default() };
        if actor.fails() {
            return Arrival::stays(actor, Branch::Stranded, still);
        }
        let Some(to) = self.step_to(actor.cell, action) else {
            let flight = if action == Action::Wait { Flight::default() } else { still };
            return Arrival::stays(actor, Branch::Held, flight);
        };
        let range_m = mission.brief.grid.cell_size_m;
        let rise_m = height_m(mission, to) - height_m(mission, actor.cell);
        let flight_time_s = libm::hypot(range_m, rise_m) / self.speed_mps;
        let flight = Flight { range_m, rise_m, flight_time_s, flights: 1, ..Flight::default() };
        let outcome = Outcome { branch: Branch::Intended, from: actor.cell, to, flight };
        Arrival { outcome, at: actor.at, detail: None }
    }

    fn step_to(&self, from: Cell, action: Action) -> Option<Cell> {
        let Action::Step(direction) = action else { return None };
        Some(match direction {
            Direction::North => Cell::new(from.x, from.y + 1),
            Direction::East => Cell::new(from.x + 1, from.y),
            Direction::South => Cell::new(from.x, from.y - 1),
            Direction::West => Cell::new(from.x - 1, from.y),
        })
    }
}

fn height_m(mission: &Mission, cell: Cell) -> f64 {
    mission.terrain.cells[index(mission, cell)].height_m
}
