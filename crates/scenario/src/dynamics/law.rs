//! The four branches of P23.

#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Rules;

/// The law has no fields: its parameters are those of `[robot]`, which planners believe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LawRules {}

impl Rules for LawRules {}
