//! What the oracle asks of a body. Each body is a file in the folder `body` that implements it for the parameters of the brief, and
//! a line in the list here.

use contract::{Action, Cell, Decision, Ground, Origin, Placement, Standing, Vetoed};

use super::Oracle;
use super::actor::{Actor, Arrival};

contract::rules! {
    /// The rules of a body.
    pub(super) fn of(Body) -> Body;
    hopper => Hopper,
    rover => Rover,
    driver => Driver,
    helicopter => Helicopter,
}

/// How robots of one body act. `number` is that of the robot.
pub(super) trait Body {
    /// Whether it hops: its landings collect treasures and count steps, and off its ground it is lost.
    fn hops(&self) -> bool {
        false
    }

    /// Whether it stands in the way of others.
    fn is_on_ground(&self) -> bool {
        true
    }

    /// The action by which it goes on along a route, if it goes from point to point.
    fn along_route(&self) -> Option<Action> {
        None
    }

    /// Whether it may do that, but for what is blocked.
    fn may(&self, oracle: &Oracle, number: usize, action: Action) -> bool;

    /// Whether an action would end on another robot or off the ground on which it can stand, or may be a trap.
    fn is_blocked(&self, _oracle: &Oracle, _number: usize, _action: Action) -> bool {
        false
    }

    /// What an action comes to.
    fn act(&self, oracle: &Oracle, number: usize, decision: Decision, action: Action) -> Arrival;

    /// Indices of the cells that it sees on the way to its next point.
    fn seen_on_way(&self, _oracle: &Oracle, _number: usize, _action: Action) -> Vec<usize> {
        Vec::new()
    }

    /// Actions that are too dangerous where so much is known of each cell, beside those that are blocked.
    fn dangerous(&self, _oracle: &Oracle, _number: usize, _known: &[Option<Ground>]) -> Vetoed {
        Vetoed::NONE
    }

    /// What it does at the deadline; `None` if that depends on what its planner has published. On along its route if that may be, or
    /// nothing.
    fn fallback(
        &self,
        oracle: &Oracle,
        number: usize,
        _known: &[Option<Ground>],
        _vetoed: Vetoed,
    ) -> Option<(Action, Origin)> {
        let along = self.along_route().filter(|action| oracle.may(number, *action));
        Some(along.map_or((Action::Hold, Origin::Hold), |action| (action, Origin::Policy)))
    }

    /// How far it may still go along routes in this stage, metres, if there is a limit.
    fn budget_left_m(&self, _actor: &Actor) -> Option<f64> {
        None
    }

    /// An action that only other bodies can take.
    fn foreign_action(&self) -> Action {
        Action::Fly
    }

    /// The cell to which a step leads, of a body that steps.
    fn step_to(&self, _from: Cell, _action: Action) -> Option<Cell> {
        None
    }
}

impl Actor {
    /// The rules of its body.
    pub fn body(&self) -> &dyn Body {
        of(&self.robot.body)
    }

    /// How it stands that acts no more by its own choice: who looks ahead from the air is never done.
    pub fn gave_up(&self) -> Standing {
        if self.body().is_on_ground() { Standing::GaveUp } else { Standing::Done }
    }

    /// What the message about all robots says of it.
    pub fn member(&self) -> contract::Member {
        contract::Member {
            at: Placement { cell: self.cell, heading: self.heading },
            ready_at_ns: self.clock_ns,
            standing: self.standing,
            waits: self.waits,
            leader: self.leader,
            last: self.last,
            travel: self.body().along_route().map(|_| self.travel()),
        }
    }
}
