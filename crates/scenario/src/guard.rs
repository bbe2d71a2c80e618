//! Section `[guard]`: what hopper-sim refuses to execute, and what it does when nobody commands.

use contract::{Guard, Profile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ScenarioError;

/// The guard between planners and the hopper. Profile paper-2023 flies without one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GuardRules {
    /// Largest probability with which an action may end off the map or on ground seen to be impassable, 0 to
    /// 1; 1 lets everything pass. 0.25 by default, which is more than all slips of a hop come to on any soil
    /// of the paper (0.2 on sand): what is vetoed is a hop that aims at ruin, slips are the planner's to weigh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hazard_max: Option<f64>,
    /// Seconds without a command that can be accepted, after which hopper-sim acts by itself: by the last
    /// policy of the planner in command, else greedily, else it holds. By default it waits for ever, standing
    /// still, so that no restart however slow changes a hop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deadline_s: Option<f64>,
}

impl GuardRules {
    /// The hazard that is let pass by default.
    pub const HAZARD_MAX: f64 = 0.25;

    /// Whether nothing is said.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The guard of a mission in `profile`, its defaults filled in here.
    pub(crate) fn settle(&mut self, profile: Profile) -> Result<Guard, ScenarioError> {
        let refuse = |field, need, got: f64| Err(ScenarioError::Value { field, need, got: got.to_string() });
        let hazard_max = self.hazard_max.unwrap_or(Self::HAZARD_MAX);
        if !(0.0..=1.0).contains(&hazard_max) {
            return refuse("guard.hazard_max", "0 to 1", hazard_max);
        }
        let deadline_s = self.deadline_s.unwrap_or(0.0);
        if self.deadline_s.is_some() && !(0.001..=1e6).contains(&deadline_s) {
            return refuse("guard.deadline_s", "0.001 to 1e6 s", deadline_s);
        }
        if profile == Profile::Paper2023 {
            *self = Self::default();
            return Ok(Guard::OFF);
        }
        self.hazard_max = Some(hazard_max);
        Ok(Guard { hazard_max, deadline_ns: (deadline_s * 1e9).round() as u64 })
    }
}
