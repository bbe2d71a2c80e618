//! What the checker asks of the robots of a mission: it knows turns, commands, records, maps and routes, and no robot.
//!
//! A model begins with a mission and follows its records. `chosen.rs` says which model a simulation has.

use std::fmt::Debug;

use contract::{
    Action, Cell, Decision, Digest, Ground, Leader, MotionParameters, Origin, Outcome, Pose, Record, RobotId,
    RunId, SensorParameters, State, Team, Vetoed, Waypoint,
};
use hopper_sim::{Execution, Mission};
use planner::Situation;

use crate::expected::Expected;
use crate::routes::Routes;
use crate::setup::Missions;

/// The group and the name of a counter.
pub(crate) type Counter = (&'static str, &'static str);

/// What a robot follows when the fallback acts for it by [`Origin::Policy`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Follows {
    /// The last policy of the planner that leads it.
    Policy,
    /// The route that it has announced.
    Route,
    /// Nothing: that origin is wrong for it.
    Nothing,
}

/// The way of a robot whose planner is given one: from where to where, how it moves, what it sees, where it is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Way {
    pub start: Cell,
    pub goal: Cell,
    pub motion: MotionParameters,
    pub sensor: SensorParameters,
    pub pose: Pose,
}

/// How long an action that came to `outcome` takes, nanoseconds.
pub(crate) fn duration_ns(outcome: &Outcome) -> u64 {
    (outcome.flight.flight_time_s * f64::from(outcome.flight.flights) * 1e9).round() as u64
}

/// The robots of a mission after some decisions, as they should be. The default answers are those of a single robot that goes from
/// cell to cell.
pub(crate) trait Model: Debug {
    /// The same model, to be changed apart.
    fn copy(&self) -> Box<dyn Model>;

    /// A model of the same kind before the first decision of `mission`. What planners have published stays known, since it may
    /// come late.
    fn anew(&self, mission: &Mission) -> Box<dyn Model>;

    /// A record was committed, as the journal holds it.
    fn committed(&mut self, record: &Record);

    /// Whose turn it is; once nobody can act, who acted last.
    fn due(&self) -> RobotId {
        RobotId(0)
    }

    /// Whether nobody acts next because all that still could wait for each other.
    fn is_all_waiting(&self) -> bool {
        false
    }

    /// Who commands a robot.
    fn leader(&self, robot: RobotId) -> Leader;

    /// The message about all robots as of the state of `decision` with `digest`. Missions of one robot publish none, and nothing compares its default.
    fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        Team { run, decision, digest, due: self.due(), actor: None, members: [].into() }
    }

    /// Simulated time from the beginning of the last action, which came to `outcome`, to that of the next, nanoseconds.
    fn lasts_ns(&self, outcome: &Outcome) -> u64 {
        duration_ns(outcome)
    }

    /// What `action` of the robot that is due comes to in the state `before`; `None` if it must be refused.
    fn execute(&self, before: &State, action: Action) -> Option<(RobotId, Execution)>;

    /// What the robot that is due must not do whatever is known of the ground, such as to go where another one is.
    fn blocked(&self) -> Vetoed {
        Vetoed::NONE
    }

    /// One action that is blocked, the most telling if there are several.
    fn blocked_action(&self) -> Option<Action> {
        None
    }

    /// What the guard vetoes where so much is known of each cell, in index order: what is blocked, and what is too dangerous.
    fn vetoed(&self, known: &[Option<Ground>]) -> Vetoed;

    /// What is done at the deadline where so much is known of each cell and `vetoed` is vetoed; `None` where that depends on what
    /// the planner has published.
    fn fallback(&self, known: &[Option<Ground>], vetoed: Vetoed) -> Option<(Action, Origin)>;

    /// What the fallback may follow for a robot.
    fn follows(&self, robot: RobotId) -> Follows;

    /// Adds what is seen after `record`, the last that was committed, or from the starts before the first.
    fn see(&self, record: Option<&Record>, expected: &mut Expected);

    /// Indices of the cells that a planner takes for impassable because other robots stand there.
    fn closed(&self, _situation: &Situation<'_>) -> Vec<usize> {
        Vec::new()
    }

    /// The way that the planner of the robot that is due is given after so many visits, if it is given one.
    fn way(&self, visits: u64) -> Option<Way>;

    /// Whether the route that monitors draw holds what a robot does.
    fn is_on_route(&self, _robot: RobotId) -> bool {
        true
    }

    /// The routes that planners have published and decisions have announced.
    fn routes(&self) -> &Routes;

    /// The same routes, to add what a planner publishes.
    fn routes_mut(&mut self) -> &mut Routes;

    /// The action by which the robot that is due goes on along a route, if it goes along one.
    fn along_route(&self) -> Option<Action> {
        None
    }

    /// The point where the robot that is due begins its next route.
    fn at(&self) -> Waypoint;

    /// The cells on which robots stand other than the one that is due.
    fn others_at(&self) -> Vec<Cell> {
        Vec::new()
    }

    /// How long the routes of the robot that is due may still be, metres, if there is a limit.
    fn budget_left_m(&self) -> Option<f64> {
        None
    }

    /// An action that only robots of another kind than the one that is due can take.
    fn foreign_action(&self) -> Action {
        Action::Fly
    }

    /// Rare events that `record` shows, which is about to be committed after the records `before`.
    fn events(&self, _missions: Missions, _record: &Record, _before: &[Record]) -> Vec<Counter> {
        Vec::new()
    }
}
