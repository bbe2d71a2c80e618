//! Numbers of a scenario within bounds.

use crate::ScenarioError;

/// Refuses lengths of 0 m and less, and above 1000 km.
pub fn positive(field: &'static str, value: f64) -> Result<(), ScenarioError> {
    in_range(field, value, f64::MIN_POSITIVE..=1e6, "a length above 0 m, at most 1e6 m")
}

/// Refuses a value beyond `range`, of which `need` says so.
pub fn in_range(
    field: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    need: &'static str,
) -> Result<(), ScenarioError> {
    if range.contains(&value) {
        Ok(())
    } else {
        Err(ScenarioError::Value { field, need, got: value.to_string() })
    }
}
