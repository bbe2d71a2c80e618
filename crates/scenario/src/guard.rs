//! Section `[guard]`: what hopper-sim refuses to execute, and what it does when no planner commands.

use contract::{Guard, Profile};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ScenarioError;

/// Rules of the guard between planners and the hopper. The profiles of papers have no guard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct GuardRules {
    /// Largest probability with which an action may end off the map or on ground seen to be impassable, 0 to
    /// 1; 1 allows everything. 0.25 by default, more than the total probability of slipping on any soil of the
    /// paper (0.2 on sand): hops aimed at a hazard are vetoed, the risk of slips is left to the planner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hazard_max: Option<f64>,
    /// Seconds without an acceptable command after which hopper-sim acts on its own: by the last policy of the
    /// planner in command, else greedily, else it holds. By default it stands still and waits for ever, so that
    /// even a slow restart changes no hop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deadline_s: Option<f64>,
}

impl GuardRules {
    /// Default of `hazard_max`.
    pub const HAZARD_MAX: f64 = 0.25;

    /// Whether the section is absent or empty, so that it is left out of the canonical text.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The guard of a mission in `profile`, with defaults filled in.
    pub(crate) fn resolve(&mut self, profile: Profile) -> Result<Guard, ScenarioError> {
        let refuse = |field, need, got: f64| Err(ScenarioError::Value { field, need, got: got.to_string() });
        let hazard_max = self.hazard_max.unwrap_or(Self::HAZARD_MAX);
        if !(0.0..=1.0).contains(&hazard_max) {
            return refuse("guard.hazard_max", "0 to 1", hazard_max);
        }
        let deadline_s = self.deadline_s.unwrap_or(0.0);
        if self.deadline_s.is_some() && !(0.001..=1e6).contains(&deadline_s) {
            return refuse("guard.deadline_s", "0.001 to 1e6 s", deadline_s);
        }
        if profile != Profile::Hopper {
            *self = Self::default();
            return Ok(Guard::OFF);
        }
        self.hazard_max = Some(hazard_max);
        Ok(Guard { hazard_max, deadline_ns: (deadline_s * 1e9).round() as u64 })
    }
}
