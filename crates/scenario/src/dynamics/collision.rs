//! The law, after the arc was checked against the ground.

#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Rules;

/// The check has no fields: its parameters are those of `[robot]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CollisionRules {}

impl Rules for CollisionRules {}
