//! A planner's policy, for the eye.

use serde::{Deserialize, Serialize};

use crate::{Action, Decision, Name, RobotId, RunId};

/// What a planner would do at one cell, and what it expects from there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolicyCell {
    /// Best action; hold where none is defined.
    pub action: Action,
    /// Value, in units of payoff.
    pub value: f64,
}

/// The policy behind one decision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Policy {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// The decision it was made for.
    pub decision: Decision,
    /// Algorithm that made it.
    pub planner: Name,
    /// Bound |V − V*| that its planner proves for each value, in units of payoff; 0 for planners without values.
    pub error_bound: f64,
    /// Cells in index order.
    pub cells: Vec<PolicyCell>,
}
