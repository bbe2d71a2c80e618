//! The bound on |V − V*| that a solution carries.
//!
//! T contracts by γ, so ‖V − V*‖ ≤ ‖V − TV‖ + ‖TV − TV*‖ ≤ ‖V − TV‖ + γ ‖V − V*‖, hence
//! ‖V − V*‖ ≤ ‖V − TV‖ / (1 − γ). What is measured is the residual in floating point; [`rounding`] bounds
//! how far that may lie below the true one.

use crate::bellman;
use crate::{GridWorld, Kind};

/// A bound on the error of values, and what it was computed from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Measured residual max |V − TV| over the free nodes, in units of payoff.
    pub residual: f64,
    /// Bound on |V − V*|, rounding included, in units of payoff.
    pub error_bound: f64,
}

impl Certificate {
    /// The certificate of a measured residual, under values and payoffs of at most `afterstate_max` together.
    #[must_use]
    pub fn new(residual: f64, discount: f64, afterstate_max: f64) -> Self {
        // A division and a sum round at most twice; the last factor covers eight roundings.
        let error_bound =
            (residual + rounding(afterstate_max)) / (1.0 - discount) * (1.0 + 4.0 * f64::EPSILON);
        Self { residual, error_bound }
    }
}

/// How far the measured residual may lie from the true one, where no afterstate value r + V exceeds `afterstate_max`.
///
/// To first order in the unit roundoff u = 2⁻⁵³, an afterstate value carries 1 u, its probability at most 4 u
/// (three sums and a product; the remainder's absolute error is below 3 u), the sum over four landings of
/// total weight 1 at most 4 u more, period and discount 5 u, and the final difference 2 u: below 20 u in all
/// of the largest afterstate value. 32 u leaves room for the higher orders.
#[must_use]
pub fn rounding(afterstate_max: f64) -> f64 {
    16.0 * f64::EPSILON * afterstate_max
}

/// Certifies `values` by one sweep straight from the definition.
///
/// # Panics
/// If `values` has not one value a node.
#[must_use]
pub fn certify(world: &GridWorld, values: &[f64]) -> Certificate {
    assert_eq!(values.len(), world.nodes(), "a certificate needs a value a node");
    let residual = (0..world.nodes()).map(|node| bellman::residual(world, values, node)).fold(0.0, f64::max);
    Certificate::new(residual, world.rules().discount, afterstate_max(world, values))
}

/// The largest |r| + |V| and |loss| that the sweep can meet.
fn afterstate_max(world: &GridWorld, values: &[f64]) -> f64 {
    let afterstate = |node: usize| match world.kind(node) {
        Kind::Free => world.payoff(node).abs() + values[node].abs(),
        Kind::Goal => world.payoff(node).abs(),
        Kind::Lost => 0.0,
    };
    (0..world.nodes()).map(afterstate).fold(world.rules().loss.abs(), f64::max)
}
