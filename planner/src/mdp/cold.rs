//! A model solved from nothing, by the solver.
//!
//! [`solver::Solver`] says how, and why its certificate holds. Here is only what differs: the model's
//! nodes have a rim around them, and a treasure absorbs like a goal. Always a cold start, so the result
//! depends on the model and the budget alone.

use solver::{Effort, Kind, Leaving, Rules, Site, Solver, Status, World};

use super::model::{Model, Node};
use crate::Budget;

/// Residual below which values count as solved, in units of payoff. Where payoffs are so large that
/// rounding alone would exceed it, [`tolerance`] is larger.
pub const TOLERANCE: f64 = 1e-9;

/// The tolerance for `model`: [`TOLERANCE`], or 64 units in the last place of the largest value possible.
#[must_use]
pub fn tolerance(model: &Model) -> f64 {
    TOLERANCE.max(64.0 * f64::EPSILON * worth_max(model))
}

/// The largest |r + V| possible, as [`World::worth_max`] has it: a free node may pay for ever, what absorbs
/// pays once.
fn worth_max(model: &Model) -> f64 {
    let (mut free, mut once) = (0.0_f64, model.loss.abs());
    for (node, payoff) in model.nodes.iter().zip(&model.payoffs) {
        match node {
            Node::Free => free = free.max(payoff.abs()),
            Node::Goal | Node::Treasure => once = once.max(payoff.abs()),
            Node::Impassable | Node::Outside => {}
        }
    }
    (free / (1.0 - model.discount)).max(once)
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

/// The solver, with buffers that are overwritten by each solve.
#[derive(Clone, Debug, Default)]
pub struct Cold {
    /// Value of each node of the model solved last; 0 at the goal, the loss where the hopper is lost.
    pub values: Vec<f64>,
    solver: Solver,
    world: Option<World>,
}

impl Cold {
    /// Solves `model` within `budget`, counted in sweeps.
    ///
    /// # Panics
    /// If the model's numbers are out of range: briefs are checked where they enter a process.
    pub fn solve(&mut self, model: &Model, budget: &Budget) -> Solution {
        let world = lay_out(&mut self.world, model);
        let error_max = tolerance(model) / (1.0 - model.discount);
        let effort = Effort { error_max, sweeps_max: budget.work_max.unwrap_or(u64::MAX) };
        let solution = self.solver.solve_with(world, &effort, &|| budget.pulse.beat());
        self.values.clear();
        self.values.resize(model.nodes.len(), model.loss);
        let inside = self.values.chunks_exact_mut(model.width).skip(1);
        for (inside, row) in inside.zip(self.solver.values().chunks_exact(world.width())) {
            inside[1..=world.width()].copy_from_slice(row);
        }
        Solution {
            sweeps: solution.sweeps,
            residual: solution.certificate.residual,
            converged: solution.status == Status::Solved,
        }
    }
}

/// The model without its rim, in the buffers of the world before if that has its size.
fn lay_out<'a>(world: &'a mut Option<World>, model: &Model) -> &'a World {
    let (width, height) = (model.width - 2, model.nodes.len() / model.width - 2);
    let rules = Rules {
        discount: model.discount,
        loss: model.loss,
        leaving: if model.leaving_is_staying { Leaving::Stays } else { Leaving::Loses },
        soils: model.soils.to_vec(),
    };
    let fits = world.as_ref().is_some_and(|world| (world.width(), world.height()) == (width, height));
    if !fits {
        *world = None;
    }
    let world = world.get_or_insert_with(|| {
        World::new(width, height, rules.clone()).expect("a brief is checked where it enters a process")
    });
    world.set_rules(rules).expect("a brief is checked where it enters a process");
    for row in 0..height {
        for column in 0..width {
            let node = (row + 1) * model.width + column + 1;
            let [slope_east, slope_north] = model.slopes[node];
            let site = Site {
                kind: match model.nodes[node] {
                    Node::Free => Kind::Free,
                    Node::Goal | Node::Treasure => Kind::Goal,
                    Node::Impassable | Node::Outside => Kind::Lost,
                },
                payoff: model.payoffs[node],
                slope_east,
                slope_north,
                soil: u8::from(model.two_periods[node]),
            };
            world.set(row * width + column, site);
        }
    }
    world
}
