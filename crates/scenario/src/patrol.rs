//! Section `[mission]`: whether the hopper goes to one goal or visits several in turn.

use contract::limits::DECISIONS_MAX;
use contract::{Cell, Patrol};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ScenarioError;

/// Which goals the hopper flies to, and in what order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum MissionKind {
    /// From the start to `brief.goal`.
    #[default]
    Reach,
    /// From goal to goal in turn, from the last to the first again, until `hops_max` hops are flown. The first goal
    /// is `brief.goal`, and `limits.steps_max` does not apply.
    Patrol,
}

/// The `[mission]` section.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MissionRules {
    /// `reach` or `patrol`.
    pub kind: MissionKind,
    /// Goals of a patrol after `brief.goal`, 1 to 15 cells (x, y), each different from the one before it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub goals: Vec<[i32; 2]>,
    /// Hops after which a patrol ends; by default as many as a mission can count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hops_max: Option<u64>,
}

impl MissionRules {
    /// Whether the section is absent or empty, so that it is left out of the canonical text.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The patrol whose first goal is `first`, with the default of `hops_max` filled in; `None` if the mission
    /// is no patrol.
    pub(crate) fn resolve(&mut self, first: Cell) -> Result<Option<Patrol>, ScenarioError> {
        let refuse = |field, need, got| Err(ScenarioError::Value { field, need, got });
        if self.kind == MissionKind::Reach {
            if self.goals.is_empty() && self.hops_max.is_none() {
                return Ok(None);
            }
            return refuse("mission.kind", "patrol, for goals or hops_max", "reach".into());
        }
        let hops_max = *self.hops_max.get_or_insert(DECISIONS_MAX);
        if !(1..=DECISIONS_MAX).contains(&hops_max) {
            return refuse("mission.hops_max", "1 to 4294967296 hops", hops_max.to_string());
        }
        let mut goals = vec![first];
        goals.extend(self.goals.iter().map(|&[x, y]| Cell::new(x, y)));
        match Patrol::new(&goals, hops_max) {
            Some(patrol) => Ok(Some(patrol)),
            None => {
                let need = "1 to 15 cells, each different from the one before it, the first and the last different from brief.goal";
                refuse("mission.goals", need, format!("{:?}", self.goals))
            }
        }
    }
}
