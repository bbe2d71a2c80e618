//! The weights of the payoff.

use serde::Serialize;

use crate::KnownError;

/// Weights of safety and information, and the payoff of the goal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weights {
    /// w1, of safety S, 0 to 1.
    pub safety: f64,
    /// w2, of information gain I, 0 to 1.
    pub information: f64,
    /// Payoff of the goal, above 0: 10, or 50 in fig. 10.
    pub goal: f64,
}

impl Weights {
    /// The goal's payoff in all figures but one.
    pub const GOAL: f64 = 10.0;
    /// The goal's payoff in fig. 10.
    pub const GOAL_RAISED: f64 = 50.0;

    /// w1 = `safety`, w2 = 1 − w1, and the goal's payoff.
    ///
    /// # Errors
    /// [`KnownError`] if w1 is not within 0 and 1, or the goal's payoff is not above 0 or too large.
    pub fn new(safety: f64, goal: f64) -> Result<Self, KnownError> {
        if !(0.0..=1.0).contains(&safety) {
            return Err(KnownError::Weight { got: safety });
        }
        if !(goal > 0.0 && goal <= 1e6) {
            return Err(KnownError::GoalPayoff { got: goal });
        }
        Ok(Self { safety, information: 1.0 - safety, goal })
    }

    /// The paper's eleven weightings: w1 = 0, 0.1 … 1, w2 = 1 − w1, goal payoff 10.
    pub fn eleven() -> impl Iterator<Item = Self> {
        (0..=10).map(|tenth: u32| {
            let (safety, information) = (f64::from(tenth) / 10.0, f64::from(10 - tenth) / 10.0);
            Self { safety, information, goal: Self::GOAL }
        })
    }
}
