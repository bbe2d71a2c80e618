//! A helicopter that looks ahead, as it should be. Which cells a camera shows along a leg is asked of the engine `helicopter`.

use contract::{Action, Branch, Decision, Flight, Helicopter, Outcome};

use super::Body;
use crate::oracle::Oracle;
use crate::oracle::actor::{Actor, Arrival};
use crate::oracle::along;
use crate::oracle::uncertain::{TOLERANCE_M, point};

impl Body for Helicopter {
    fn is_on_ground(&self) -> bool {
        false
    }

    fn along_route(&self) -> Option<Action> {
        Some(Action::Fly)
    }

    fn may(&self, oracle: &Oracle, number: usize, action: Action) -> bool {
        let actor = &oracle.turns.actors[number];
        let left_m = self.budget_m - actor.flown_m;
        match (action, actor.next()) {
            (Action::Fly, Some(to)) => point(actor.at).distance_m(point(to)) <= left_m + TOLERANCE_M,
            (Action::Fly, None) => false,
            _ => along::may(oracle, number, action),
        }
    }

    fn act(&self, oracle: &Oracle, number: usize, _decision: Decision, action: Action) -> Arrival {
        let actor = &oracle.turns.actors[number];
        let (false, Action::Fly, Some(at)) = (actor.fails(), action, actor.next()) else {
            return along::stays(actor, action);
        };
        let range_m = point(actor.at).distance_m(point(at));
        let flight_time_s = range_m / self.speed_mps;
        let flight = Flight { range_m, flight_time_s, flights: 1, ..Flight::default() };
        let to = oracle.uncertain.cell(at);
        Arrival {
            outcome: Outcome { branch: Branch::Intended, from: actor.cell, to, flight },
            at,
            detail: None,
        }
    }

    fn seen_on_way(&self, oracle: &Oracle, number: usize, action: Action) -> Vec<usize> {
        let actor = &oracle.turns.actors[number];
        match (action, actor.next(), actor.robot.sensor.view_m()) {
            (Action::Fly, Some(to), Some(radius_m)) => oracle.uncertain.swath(actor.at, to, radius_m),
            _ => Vec::new(),
        }
    }

    fn budget_left_m(&self, actor: &Actor) -> Option<f64> {
        Some(self.budget_m - actor.flown_m)
    }

    fn foreign_action(&self) -> Action {
        Action::Drive
    }
}
