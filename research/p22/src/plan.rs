//! A plan: the values and the policy of a map, and the path from its start.

use crate::{Experiment, KnownMap, Model, Path, Reading, Solution, Weights, solve};

/// The solution of one map under one weighting.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Weights of the payoff.
    pub weights: Weights,
    /// Value and choice of every cell.
    pub solution: Solution,
    /// Path of the intended hops from the start.
    pub path: Path,
}

impl Plan {
    /// Plans on `map`; `model` must be its model under `reading`.
    #[must_use]
    pub fn new(map: &KnownMap, model: &Model, reading: &Reading, weights: Weights) -> Self {
        let payoffs = model.payoffs(&weights);
        let solution = solve(model, &payoffs, model.goal_value(&weights), reading.tolerance);
        let path = Path::follow(map, model, &solution);
        Self { weights, solution, path }
    }

    /// Plans one of the paper's experiments, building its map and model.
    #[must_use]
    pub fn of(experiment: Experiment, reading: &Reading, weights: Weights) -> Self {
        let map = KnownMap::new(experiment, reading);
        Self::new(&map, &Model::new(&map, reading), reading, weights)
    }
}
