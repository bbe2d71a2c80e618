//! One plan of the paper, as its claims see it.

use serde::Serialize;

use crate::{Experiment, Path, Weights};

/// One plan of the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// Simulation of the paper that it belongs to.
    pub experiment: Experiment,
    /// Weights of the payoff.
    pub weights: Weights,
    /// Path that the policy intends.
    pub path: Path,
    /// Number of sweeps of value iteration that chose actions.
    pub sweeps: u32,
    /// Whether the values converged.
    pub settled: bool,
}
