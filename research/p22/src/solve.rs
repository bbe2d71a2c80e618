//! Value iteration over all cells (P22 Algorithm 1).

use crate::Model;

/// Sweeps after which solving is given up; 1,700 reach 1e-6 at γ = 0.99.
const SWEEPS_MAX: u32 = 50_000;
/// Sweeps that keep the policy, between two that improve it, if the fixed point is asked for.
const KEEPING_SWEEPS: u32 = 12;
/// Larger tolerances are readings of the paper's stop criterion; then every sweep improves the policy.
const FIXED_POINT_TOLERANCE: f64 = 1e-6;

/// A value and a choice for every cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Value V of every cell, in index order.
    pub values: Vec<f64>,
    /// Index into [`Model::choices`] of every cell; `None` where no hop is possible, and at a goal that ends the
    /// trial.
    pub policy: Vec<Option<usize>>,
    /// Number of sweeps that improved the policy; those that kept it are not counted.
    pub sweeps: u32,
    /// Whether the values converged within the tolerance.
    pub settled: bool,
}

/// Solves V(x) = γ max_u [r(x, u) + Σ p V(x′)] in place, cell by cell in index order, from V = min r until
/// no value changes by more than `tolerance` in a sweep; the policy is the best choice under the final
/// values, the first of equals.
#[must_use]
pub fn solve(model: &Model, payoffs: &[f64], goal_value: f64, tolerance: f64) -> Solution {
    let discount = model.discount;
    let lowest = payoffs.iter().copied().fold(f64::INFINITY, f64::min);
    let mut values = vec![lowest.min(0.0); model.cells() + 1];
    // One more than the map has cells: the end of the trial, of value 0.
    values[model.cells()] = 0.0;
    if let Some(goal) = model.pinned_goal {
        values[goal] = goal_value;
    }
    let mut policy = vec![None; model.cells()];
    let (mut sweeps, mut settled) = (0, false);
    while !settled && sweeps < SWEEPS_MAX {
        let mut change: f64 = 0.0;
        for cell in 0..model.cells() {
            let Some((choice, action_value)) = best(model, payoffs, &values, cell) else { continue };
            let value = discount * action_value;
            change = change.max((value - values[cell]).abs());
            values[cell] = value;
            policy[cell] = Some(choice);
        }
        sweeps += 1;
        settled = change <= tolerance;
        if settled || tolerance > FIXED_POINT_TOLERANCE {
            continue;
        }
        for _ in 0..KEEPING_SWEEPS {
            for cell in 0..model.cells() {
                if let Some(choice) = policy[cell] {
                    values[cell] = discount * action_value(model, payoffs, &values, choice);
                }
            }
        }
    }
    for (cell, choice) in policy.iter_mut().enumerate() {
        *choice = best(model, payoffs, &values, cell).map(|(choice, _)| choice);
    }
    values.truncate(model.cells());
    Solution { values, policy, sweeps, settled }
}

fn best(model: &Model, payoffs: &[f64], values: &[f64], cell: usize) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for choice in model.choices_of(cell) {
        let action_value = action_value(model, payoffs, values, choice);
        if best.is_none_or(|(_, least)| action_value > least) {
            best = Some((choice, action_value));
        }
    }
    best
}

#[inline]
fn action_value(model: &Model, payoffs: &[f64], values: &[f64], choice: usize) -> f64 {
    let landings = &model.landings[choice];
    landings.iter().fold(payoffs[choice], |sum, landing| sum + landing.factor * values[landing.index])
}
