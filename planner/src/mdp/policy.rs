//! The greedy policy under given values, with a total order among equals.
//!
//! Actions whose values lie within [`TIE`] of the best count as equal, and the first of north, east, south,
//! west is taken: [`solver::online::choice`], however the values were solved.

use contract::{Action, Direction, PolicyCell, Vetoed};
use solver::online::choice::TIE;
use solver::{GridWorld, Hop, action_values};

use super::hop_lattice::HopLattice;
use crate::tie::first_best_allowed;

/// The action that commands `hop`.
#[must_use]
pub fn to_action(hop: Hop) -> Action {
    Action::Hop(match hop {
        Hop::North => Direction::North,
        Hop::East => Direction::East,
        Hop::South => Direction::South,
        Hop::West => Direction::West,
    })
}

/// The action at a node: hold where the node is not free.
#[must_use]
pub fn action(world: &GridWorld, values: &[f64], node: usize) -> Action {
    solver::policy::hop(world, values, node, TIE).map_or(Action::Hold, to_action)
}

/// The best action at the hopper's node among those that are not `vetoed`.
#[must_use]
pub fn allowed_action(world: &GridWorld, values: &[f64], node: usize, vetoed: Vetoed) -> Action {
    // The solver's hops are in the order of the contract's directions.
    let values = action_values(world, values, node).map(Some);
    first_best_allowed(values, TIE, vetoed).map_or(Action::Hold, Action::Hop)
}

/// Action and value of every cell of the grid in index order; hold and 0 off the hop lattice.
#[must_use]
pub fn cells(world: &GridWorld, lattice: &HopLattice, values: &[f64]) -> Vec<PolicyCell> {
    let policy_cell = |cell| match lattice.node(cell) {
        Some(node) => PolicyCell { action: action(world, values, node), value: values[node] },
        None => PolicyCell { action: Action::Hold, value: 0.0 },
    };
    lattice.grid.iter().map(policy_cell).collect()
}
