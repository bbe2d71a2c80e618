//! Ranges of values.

use serde::{Deserialize, Serialize};

/// All values from `min` to `max`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Lower end; not above `max`.
    pub min: f64,
    /// Upper end, not below the lower.
    pub max: f64,
}

impl Range {
    /// Where `value` lies between the ends: 0 at the lower, 1 at the upper, beyond outside; 0 on an empty range.
    #[must_use]
    pub fn normalise(&self, value: f64) -> f64 {
        let width = self.max - self.min;
        if width > 0.0 { (value - self.min) / width } else { 0.0 }
    }
}
