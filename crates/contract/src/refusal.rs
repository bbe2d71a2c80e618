//! Why a message was not acted upon.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{Action, Cell, Decision, Digest, Incarnation, RobotId, RouteId, RunId, Term};

/// Why a message was not acted upon: `need` is what was needed, `got` what the message had.
#[allow(missing_docs, reason = "the error texts say what each field is")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Refusal {
    /// Meant for another run.
    #[error("needs run {need}, got run {got}")]
    WrongRun { need: RunId, got: RunId },
    /// Meant for a robot the mission has not.
    #[error("needs robot below {robots}, got {got}")]
    WrongRobot { robots: u16, got: u32 },
    /// The decision was taken before; its outcome stands.
    #[error("decision {got} is taken, {need} is due")]
    RepeatedDecision { need: Decision, got: Decision },
    /// The decision is not due yet.
    #[error("decision {got} is not due, {need} is")]
    FutureDecision { need: Decision, got: Decision },
    /// It answers a state of another past: the journal has lost its tail, or was replaced, while it was planned.
    #[error(
        "decision {decision} is due after the past with digest {need}, got a command for the past with digest {got}"
    )]
    OtherPast { decision: Decision, need: Digest, got: Digest },
    /// The term has passed.
    #[error("term {got} has passed, {need} is in force")]
    StaleTerm { need: Term, got: Term },
    /// The term leaps ahead.
    #[error("term {got} leaps ahead of {need}, which is in force")]
    FutureTerm { need: Term, got: Term },
    /// The term is in force, but another planner holds it.
    #[error("term {term} is held by another planner")]
    NotLeader { term: Term },
    /// No heartbeat of the sender has been heard yet, so its build is not known; it sends again.
    #[error("no heartbeat of life {incarnation} has been heard yet")]
    UnknownLife { incarnation: Incarnation },
    /// Another planner has asked for the next term, and this decision is kept for it a while.
    #[error("decision {decision} is kept for a planner that takes over")]
    Yielding { decision: Decision },
    /// The guard holds the action to be too dangerous.
    #[error("{action} needs a hazard of at most {need}, got {got}: vetoed")]
    Vetoed {
        action: Action,
        /// Largest hazard allowed.
        need: f64,
        /// Probability of ending off the map or on ground seen to be impassable.
        got: f64,
    },
    /// Something is in the way of the hop's arc, or the vertical hop is not offered.
    #[error("{action} needs {need}: vetoed")]
    Blocked { action: Action, need: String },
    /// Another robot stands where the action would lead.
    #[error("{action} needs a free cell, robot {robot} stands on {cell}: vetoed")]
    Occupied { action: Action, cell: Cell, robot: RobotId },
    /// It is another robot's turn.
    #[error("robot {got} is not due, robot {need} is")]
    NotDue { need: RobotId, got: RobotId },
    /// The points of the announced route have not been received; its sender sends them again.
    #[error("route {route} is announced, but its points have not been received")]
    UnknownRoute { route: RouteId },
    /// The flight is longer than what is left of the budget.
    #[error("a flight needs at most {need} m, got {got} m")]
    BeyondBudget {
        /// Metres that are left.
        need: f64,
        /// Metres of the flight.
        got: f64,
    },
    /// The mission is over.
    #[error("the mission is over")]
    MissionOver,
    /// A hop is being executed; the answer will be the next state.
    #[error("decision {decision} is being executed")]
    Busy { decision: Decision },
    /// A field is out of range.
    #[error("field {field} needs {need}, got {got}")]
    Malformed { field: String, need: String, got: String },
}

impl Refusal {
    /// A field out of range.
    #[must_use]
    pub fn malformed(field: &str, need: &str, got: impl std::fmt::Display) -> Self {
        Self::Malformed { field: field.into(), need: need.into(), got: got.to_string() }
    }

    /// The action that would be refused again from there, whoever commanded it, so that it counts as vetoed.
    #[must_use]
    pub fn vetoed(&self) -> Option<Action> {
        match self {
            Refusal::Vetoed { action, .. }
            | Refusal::Blocked { action, .. }
            | Refusal::Occupied { action, .. } => Some(*action),
            _ => None,
        }
    }

    /// The reason's name, under which it is counted.
    #[must_use]
    pub fn reason(&self) -> &'static str {
        match self {
            Refusal::WrongRun { .. } => "wrong_run",
            Refusal::WrongRobot { .. } => "wrong_robot",
            Refusal::RepeatedDecision { .. } => "repeated_decision",
            Refusal::FutureDecision { .. } => "future_decision",
            Refusal::OtherPast { .. } => "other_past",
            Refusal::StaleTerm { .. } => "stale_term",
            Refusal::FutureTerm { .. } => "future_term",
            Refusal::NotLeader { .. } => "not_leader",
            Refusal::UnknownLife { .. } => "unknown_life",
            Refusal::Yielding { .. } => "yielding",
            Refusal::Vetoed { .. } | Refusal::Blocked { .. } => "vetoed",
            Refusal::Occupied { .. } => "occupied",
            Refusal::NotDue { .. } => "not_due",
            Refusal::UnknownRoute { .. } => "unknown_route",
            Refusal::BeyondBudget { .. } => "beyond_budget",
            Refusal::MissionOver => "mission_over",
            Refusal::Busy { .. } => "busy",
            Refusal::Malformed { .. } => "malformed",
        }
    }
}

/// How often each reason came up.
#[derive(Clone, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RefusalCounts(pub BTreeMap<String, u64>);

impl RefusalCounts {
    /// Counts one more refusal.
    pub fn count(&mut self, refusal: &Refusal) {
        *self.0.entry(refusal.reason().into()).or_default() += 1;
    }

    /// How often `reason` came up.
    #[must_use]
    pub fn of(&self, reason: &str) -> u64 {
        self.0.get(reason).copied().unwrap_or(0)
    }
}
