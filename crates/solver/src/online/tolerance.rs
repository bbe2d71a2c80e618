//! The tolerances of the online solver.

/// Bound on the error of the online solver's values, in units of payoff: a little below the promised 1e-6.
pub const VALUE_ERROR: f64 = 0.99e-6;

/// Tolerances at which the bounds around the hopper are tried in turn, in units of the finest. Most decisions are clear
/// at the first.
pub(super) const STAGES: [f64; 5] = [1e4, 1e3, 1e2, 1e1, 1.0];
