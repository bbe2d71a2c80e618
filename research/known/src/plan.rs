//! A plan: what to do in every cell, and where that leads from the start.

use crate::{Experiment, KnownError, Model, Path, Reading, Solution, World, solve};
use serde::Serialize;

/// What the payoff weighs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weights {
    /// w1, of safety S.
    pub safety: f64,
    /// w2, of information gain I.
    pub information: f64,
    /// The payoff of the goal: 10, or 50 in fig. 10.
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
    /// [`KnownError`] if w1 is not within 0 and 1, or the goal's payoff not above 0 or too large.
    pub fn new(safety: f64, goal: f64) -> Result<Self, KnownError> {
        if !(0.0..=1.0).contains(&safety) {
            return Err(KnownError::Weight { got: safety });
        }
        if !(goal > 0.0 && goal <= 1e6) {
            return Err(KnownError::GoalPayoff { got: goal });
        }
        Ok(Self { safety, information: 1.0 - safety, goal })
    }

    /// The paper's eleven: w1 = 0, 0.1 … 1 with w2 = 1 − w1 and the goal's payoff 10.
    pub fn eleven() -> impl Iterator<Item = Self> {
        (0..=10).map(|tenth: u32| {
            let (safety, information) = (f64::from(tenth) / 10.0, f64::from(10 - tenth) / 10.0);
            Self { safety, information, goal: Self::GOAL }
        })
    }
}

/// A solved world.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What was weighed.
    pub weights: Weights,
    /// Values and policy.
    pub solution: Solution,
    /// Where the policy's intended moves lead from the start.
    pub path: Path,
}

impl Plan {
    /// Plans in `world`, whose model under `reading` is `model`.
    #[must_use]
    pub fn new(world: &World, model: &Model, reading: &Reading, weights: Weights) -> Self {
        let payoffs = model.payoffs(&weights);
        let solution = solve(model, &payoffs, model.goal_value(&weights), reading.tolerance);
        let path = Path::follow(world, model, &solution);
        Self { weights, solution, path }
    }

    /// Plans one of the paper's experiments from nothing.
    #[must_use]
    pub fn of(experiment: Experiment, reading: &Reading, weights: Weights) -> Self {
        let world = World::new(experiment, reading);
        Self::new(&world, &Model::new(&world, reading), reading, weights)
    }
}
