//! What robots that go along routes have in common: they announce, hold, wait and are done, and end their stages together.

use contract::{Action, Branch, Decision, Flight, Outcome, Reach, RobotId, Standing};

use super::Oracle;
use super::actor::{Actor, Arrival};
use super::uncertain::{TOLERANCE_M, point};

/// Whether a robot may do that, which is not to go on along its route.
pub(super) fn may(oracle: &Oracle, number: usize, action: Action) -> bool {
    let id = match action {
        Action::Hold | Action::Wait | Action::Done => return true,
        Action::Announce(id) => id,
        _ => return false,
    };
    let Some(points) = oracle.routes.points(RobotId(number as u16), id) else { return false };
    let actor = &oracle.turns.actors[number];
    let begins_m = point(points[0]).distance_m(point(actor.at));
    let length_m: f64 = points.windows(2).map(|leg| point(leg[0]).distance_m(point(leg[1]))).sum();
    let on_map = points.iter().all(|at| oracle.uncertain.contains(*at));
    let budget_m = actor.body().budget_left_m(actor);
    let is_within_budget = budget_m.is_none_or(|left_m| length_m <= left_m + TOLERANCE_M);
    on_map && begins_m <= TOLERANCE_M && is_within_budget
}

/// What an action comes to by which a robot does not move, or at which it fails.
pub(super) fn stays(actor: &Actor, action: Action) -> Arrival {
    let still = |flight_time_s| Flight { flight_time_s, flights: 1, ..Flight::default() };
    if actor.fails() {
        return Arrival::stays(actor, Branch::Stranded, still(1.0));
    }
    let takes_s = if matches!(action, Action::Wait | Action::Done) { 0.0 } else { 1.0 };
    Arrival::stays(actor, Branch::Held, still(takes_s))
}

/// Whether a robot is within the radius of its goal and has no further point to go to.
pub(super) fn has_reached(oracle: &Oracle, number: usize, reach: &Reach) -> bool {
    let actor = &oracle.turns.actors[number];
    let away_m = point(actor.at).distance_m(point(reach.at));
    away_m <= reach.radius_m + TOLERANCE_M && actor.next().is_none()
}

/// A robot has acted.
pub(super) fn take(oracle: &mut Oracle, number: usize, decision: Decision, action: Action) {
    let Arrival { outcome, at, .. } =
        oracle.turns.actors[number].body().act(oracle, number, decision, action);
    let has_failed = outcome.branch == Branch::Stranded && outcome.flight.range_m == 0.0;
    if !has_failed {
        look(oracle, number, action);
    }
    let route = match action {
        Action::Announce(id) => oracle.routes.points(RobotId(number as u16), id).map(|points| (id, points)),
        _ => None,
    };
    let route = route.map(|(id, points)| (id, points.to_vec(), decision));
    oracle.turns.begin(number);
    let actor = &mut oracle.turns.actors[number];
    actor.actions += 1;
    match (outcome.branch, action) {
        (Branch::Stranded, _) => actor.standing = Standing::Stranded,
        (Branch::Halted, _) => {
            actor.driven = vec![at];
            (actor.moved, actor.halted, actor.halts) = (Some(decision), Some(decision), actor.halts + 1);
        }
        (_, Action::Wait) => {
            (actor.waits, actor.waited) = (true, actor.waited + 1);
            return;
        }
        (_, Action::Done) => {
            actor.standing = actor.gave_up();
            return;
        }
        (_, Action::Announce(_)) => (actor.route, actor.reached) = (route, 0),
        (_, Action::Drive | Action::Fly) => {
            (actor.reached, actor.moved) = (actor.reached + 1, Some(decision));
            actor.driven.push(at);
            if action == Action::Fly {
                actor.flown_m += outcome.flight.range_m;
            }
        }
        _ => {}
    }
    (actor.at, actor.cell) = (at, outcome.to);
    let Outcome { branch, flight, .. } = outcome;
    oracle.turns.busy(number, flight.flight_time_s);
    if branch == Branch::Halted {
        gather(oracle, number);
    }
}

/// What a robot sees on the way to its next point.
fn look(oracle: &mut Oracle, number: usize, action: Action) {
    let actor = &oracle.turns.actors[number];
    let (cells, sensor) = (actor.body().seen_on_way(oracle, number, action), actor.robot.sensor);
    oracle.show(cells, sensor.accuracy().is_some());
}

/// A stage has ended: all that still look ahead from the air are with the robot that ended it, fresh, and act no earlier than it.
fn gather(oracle: &mut Oracle, ended: usize) {
    let Actor { at, cell, clock_ns, .. } = oracle.turns.actors[ended];
    for actor in &mut oracle.turns.actors {
        if !actor.body().is_on_ground() && actor.is_active() {
            (actor.at, actor.cell, actor.clock_ns) = (at, cell, actor.clock_ns.max(clock_ns));
            (actor.route, actor.reached, actor.flown_m) = (None, 0, 0.0);
        }
    }
}
