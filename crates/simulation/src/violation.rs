//! What a checker finds.

use serde::Serialize;

/// A promise that did not hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// The promise that was broken, by the name of its rule.
    pub rule: &'static str,
    /// What was needed, and what was seen instead.
    pub detail: String,
}
