//! The policy that values imply, with a total order among equals.

use contract::{Action, Cell, PolicyCell, Vetoed};
use solver::online::choice::TIE;

use super::cold::tolerance;
use super::model::{Model, Node};
use crate::tie::{first_best, first_best_allowed};

/// Actions whose values lie within δ of the best count as equal, and the first of north, east, south,
/// west is taken. δ is the session's ([`TIE`]), and at least ten times the error tolerance / (1 − γ) that a
/// solved value can have: 1e-6 at γ = 0.99.
#[must_use]
pub fn tie_tolerance(model: &Model) -> f64 {
    TIE.max(10.0 * tolerance(model) / (1.0 - model.discount))
}

/// The action at a node: hold wherever nothing is left to decide.
#[must_use]
pub fn action(model: &Model, values: &[f64], node: usize) -> Action {
    action_within(model, values, node, tie_tolerance(model))
}

/// The best action at the hopper's node among those that are not `vetoed`.
#[must_use]
pub fn allowed_action(model: &Model, values: &[f64], node: usize, vetoed: Vetoed) -> Action {
    let action_values = model.action_values(values, node).map(Some);
    first_best_allowed(action_values, tie_tolerance(model), vetoed).map_or(Action::Hold, Action::Hop)
}

/// [`action`] with a tie tolerance computed beforehand: it takes a look at every cell.
fn action_within(model: &Model, values: &[f64], node: usize, tie: f64) -> Action {
    if model.nodes[node] != Node::Free {
        return Action::Hold;
    }
    first_best(model.action_values(values, node).map(Some), tie).map_or(Action::Hold, Action::Hop)
}

/// Action and value of every cell of the grid in index order; hold and 0 off the goal's lattice.
#[must_use]
pub fn cells(model: &Model, values: &[f64]) -> Vec<PolicyCell> {
    let tie = tie_tolerance(model);
    let policy_cell = |cell: Cell| match model.node(cell) {
        Some(node) => PolicyCell { action: action_within(model, values, node, tie), value: values[node] },
        None => PolicyCell { action: Action::Hold, value: 0.0 },
    };
    model.grid().iter().map(policy_cell).collect()
}
