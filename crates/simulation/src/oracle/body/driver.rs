//! A rover that drives from point to point over uncertain ground, as it should be. What a drive takes is asked of the engine
//! `rover`.

use contract::{Action, Branch, Decision, Driver, Flight, Outcome, Waypoint};
use rover::{Allowance, Drive, DriveEnd, Point, SOL_HOURS};

use super::Body;
use crate::oracle::Oracle;
use crate::oracle::actor::Arrival;
use crate::oracle::along;
use crate::oracle::uncertain::point;

/// The longest that a rover drives in a stage which is not the last, in Sol.
const STAGE_SOL: f64 = 1.0;

impl Body for Driver {
    fn along_route(&self) -> Option<Action> {
        Some(Action::Drive)
    }

    fn may(&self, oracle: &Oracle, number: usize, action: Action) -> bool {
        match action {
            Action::Drive => oracle.turns.actors[number].next().is_some(),
            _ => along::may(oracle, number, action),
        }
    }

    /// A drive that is too dangerous by what anybody can know, or ends where another robot is.
    fn is_blocked(&self, oracle: &Oracle, number: usize, action: Action) -> bool {
        let is_taken = |to| oracle.is_occupied(number, oracle.uncertain.cell(to));
        let next = oracle.turns.actors[number].next();
        action == Action::Drive && (is_trap(oracle, number) || next.is_some_and(is_taken))
    }

    fn act(&self, oracle: &Oracle, number: usize, _decision: Decision, action: Action) -> Arrival {
        let actor = &oracle.turns.actors[number];
        let (false, Action::Drive, Some(to)) = (actor.fails(), action, actor.next()) else {
            return along::stays(actor, action);
        };
        let drive = leg(oracle, number, to);
        let at = Waypoint { x_m: drive.at.x_m, y_m: drive.at.y_m };
        let (branch, at) = match drive.end {
            DriveEnd::Stuck { .. } => (Branch::Stranded, at),
            DriveEnd::OutOfTime => (Branch::Halted, at),
            DriveEnd::Arrived => (Branch::Intended, to),
        };
        let (range_m, flight_time_s) = (drive.length_m, drive.duration_sol * SOL_HOURS * 3600.0);
        let flight = Flight { range_m, flight_time_s, flights: 1, ..Flight::default() };
        let to = oracle.uncertain.cell(at);
        Arrival { outcome: Outcome { branch, from: actor.cell, to, flight }, at, detail: None }
    }

    fn seen_on_way(&self, oracle: &Oracle, number: usize, action: Action) -> Vec<usize> {
        match (action, oracle.turns.actors[number].next()) {
            (Action::Drive, Some(to)) => leg(oracle, number, to).sensed,
            _ => Vec::new(),
        }
    }
}

/// Whether the drive to its next point is too dangerous by what anybody can know.
fn is_trap(oracle: &Oracle, number: usize) -> bool {
    let (actor, hazard_max) = (&oracle.turns.actors[number], oracle.mission.brief.guard.hazard_max);
    let hazard = |to| oracle.uncertain.hazard(&oracle.shown, actor.at, to);
    actor.next().is_some_and(|to| hazard(to) > hazard_max)
}

/// The drive to its next point: in all stages but the last, as far as it comes within a Sol from where the stage began.
fn leg(oracle: &Oracle, number: usize, to: Waypoint) -> Drive {
    let actor = &oracle.turns.actors[number];
    let driven: Vec<Point> = actor.driven.iter().copied().map(point).collect();
    let before = oracle.uncertain.drive(&driven, Allowance::UNLIMITED);
    let stages = oracle.mission.brief.sampling.map_or(1, |sampling| sampling.stages);
    let is_last = actor.halts + 1 >= stages;
    let limit_sol = if is_last { f64::INFINITY } else { STAGE_SOL };
    let allowance = Allowance { used_sol: before.duration_sol, limit_sol };
    oracle.uncertain.drive(&[point(actor.at), point(to)], allowance)
}
