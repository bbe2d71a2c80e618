//! Gauss–Seidel value iteration in causal order, certified by an independent last sweep.
//!
//! The sweeps leave the goal outwards, row by row: news of the goal crosses the whole map in one.
//! The share of a hop that ends where it began is solved for instead of iterated (V = a + bV is
//! V = a / (1 − b)), which leaves the fixed point where it is. Always a cold start, so the result
//! depends on the model alone.
//!
//! When no value changes by more than the tolerance any more, a Jacobi sweep written straight from
//! the definition ([`Model::action_values`], none of this module's kernel) measures the residual
//! max |V − TV|; if that exceeds the tolerance, sweeping goes on. Then |V − V*| ≤ residual · γ/(1−γ)
//! holds for the values it certifies, rounding aside.

use contract::Direction;

use super::model::{Model, Node};
use crate::Budget;

/// Residual below which values count as solved, in units of payoff. Where payoffs are so large that
/// rounding alone would exceed it, [`tolerance`] is larger.
pub const TOLERANCE: f64 = 1e-9;

/// The tolerance for `model`: [`TOLERANCE`], or 64 units in the last place of the largest value possible.
#[must_use]
pub fn tolerance(model: &Model) -> f64 {
    TOLERANCE.max(64.0 * f64::EPSILON * value_max(model))
}

/// Largest |V| possible.
fn value_max(model: &Model) -> f64 {
    let largest = |treasure: bool| {
        let payoffs = model.nodes.iter().zip(&model.payoffs);
        let such = payoffs.filter(|(node, _)| (**node == Node::Treasure) == treasure);
        such.fold(0.0_f64, |max, (_, payoff)| max.max(payoff.abs()))
    };
    // What a treasure is worth is paid once.
    (largest(false) / (1.0 - model.discount) + largest(true)).max(model.loss.abs())
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Sweeps made; the check is not counted.
    pub sweeps: u64,
    /// Residual max |V − TV| of the independent last sweep.
    pub residual: f64,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
}

/// Linear form of one node's four hops: constant, and coefficients of the worths ahead, left, right.
#[derive(Clone, Copy, Debug, Default)]
struct Backup {
    constant: [f64; 4],
    ahead: [f64; 4],
    left: [f64; 4],
    right: [f64; 4],
}

/// The solver, with buffers that are overwritten by each solve.
#[derive(Clone, Debug, Default)]
pub struct ValueIteration {
    /// Value of each node of the model solved last; 0 where it absorbs, the loss where the hopper is lost.
    pub values: Vec<f64>,
    /// r + V of each node.
    worths: Vec<f64>,
    /// Backups of the free nodes, in the order of the sweep.
    backups: Vec<Backup>,
    /// The free nodes in the order of the sweep.
    order: Vec<usize>,
}

impl ValueIteration {
    /// Solves `model` within `budget`, counted in sweeps.
    pub fn solve(&mut self, model: &Model, budget: &Budget) -> Solution {
        let tolerance = tolerance(model);
        let sweeps_max = budget.work_max.unwrap_or(u64::MAX).min(sweeps_enough(model, tolerance));
        self.compile(model);
        let mut sweeps = 0;
        loop {
            let mut change = f64::INFINITY;
            while change > tolerance && sweeps < sweeps_max {
                change = self.sweep(model.width);
                sweeps += 1;
                budget.pulse.beat();
            }
            self.extract(model);
            let residual = residual(model, &self.values);
            let converged = residual <= tolerance;
            if converged || sweeps == sweeps_max {
                return Solution { sweeps, residual, converged };
            }
        }
    }

    fn compile(&mut self, model: &Model) {
        let worst = model.free().map(|node| model.payoffs[node]).fold(f64::INFINITY, f64::min);
        self.worths.clear();
        self.worths.extend(model.nodes.iter().zip(&model.payoffs).map(|(node, payoff)| match node {
            Node::Free => payoff + worst,
            Node::Goal | Node::Treasure => *payoff,
            Node::Impassable | Node::Outside => model.loss,
        }));
        outwards(model, &mut self.order);
        self.backups.clear();
        self.backups.extend(self.order.iter().map(|&node| Backup::new(model, node)));
    }

    /// One sweep; the largest change of a value.
    fn sweep(&mut self, width: usize) -> f64 {
        let worths = &mut self.worths[..];
        let mut change = 0.0_f64;
        for (&node, backup) in self.order.iter().zip(&self.backups) {
            let [north, east] = [worths[node + width], worths[node + 1]];
            let [south, west] = [worths[node - width], worths[node - 1]];
            let ahead = [north, east, south, west];
            let left = [west, north, east, south];
            let right = [east, south, west, north];
            let mut best = [0.0; 4];
            for hop in 0..4 {
                best[hop] = backup.constant[hop]
                    + backup.ahead[hop] * ahead[hop]
                    + backup.left[hop] * left[hop]
                    + backup.right[hop] * right[hop];
            }
            let best = best[0].max(best[1]).max(best[2].max(best[3]));
            change = change.max((best - worths[node]).abs());
            worths[node] = best;
        }
        change
    }

    fn extract(&mut self, model: &Model) {
        self.values.clear();
        self.values.extend(model.nodes.iter().enumerate().map(|(index, node)| match node {
            Node::Free => self.worths[index] - model.payoffs[index],
            Node::Goal | Node::Treasure => 0.0,
            Node::Impassable | Node::Outside => model.loss,
        }));
    }
}

impl Backup {
    /// The backup of the worth r + V at `node`, with what stays at the node solved for.
    fn new(model: &Model, node: usize) -> Self {
        let payoff = model.payoffs[node];
        let (first_period, discount) = if model.two_periods[node] {
            (model.discount * payoff, model.discount * model.discount)
        } else {
            (0.0, model.discount)
        };
        let mut backup = Self::default();
        for direction in Direction::ALL {
            let hop = direction as usize;
            let landings = model.landings(node, direction);
            let stays: f64 = landings.iter().filter(|(to, _)| *to == node).map(|(_, p)| p).sum();
            let scale = 1.0 / (1.0 - discount * stays);
            let [ahead, _, left, right] =
                landings.map(|(to, p)| if to == node { 0.0 } else { discount * p * scale });
            backup.constant[hop] = payoff + (first_period + discount * stays * payoff) * scale;
            backup.ahead[hop] = ahead;
            backup.left[hop] = left;
            backup.right[hop] = right;
        }
        backup
    }
}

/// Residual max |V − TV| over the free nodes, by one Jacobi sweep from the definition.
#[must_use]
pub fn residual(model: &Model, values: &[f64]) -> f64 {
    let deviation = |node: usize| {
        let best = model.action_values(values, node).into_iter().fold(f64::NEG_INFINITY, f64::max);
        (best - values[node]).abs()
    };
    model.free().map(deviation).fold(0.0, f64::max)
}

/// Sweeps after which the contraction by γ a sweep has brought any start within the tolerance.
fn sweeps_enough(model: &Model, tolerance: f64) -> u64 {
    let start_error = 4.0 * value_max(model).max(tolerance);
    let sweeps = libm::log(tolerance / start_error) / libm::log(model.discount);
    sweeps.ceil() as u64 + 1
}

/// The free nodes from the goal outwards: its row first, then those north of it, then those south;
/// within a row its column first, then eastwards, then westwards.
fn outwards(model: &Model, order: &mut Vec<usize>) {
    let height = model.nodes.len() / model.width;
    let goal = model.nodes.iter().position(|&node| node == Node::Goal).expect("the goal is on its lattice");
    let (goal_row, goal_column) = (goal / model.width, goal % model.width);
    order.clear();
    for row in (goal_row..height - 1).chain((1..goal_row).rev()) {
        for column in (goal_column..model.width - 1).chain((1..goal_column).rev()) {
            let node = row * model.width + column;
            if model.nodes[node] == Node::Free {
                order.push(node);
            }
        }
    }
}
