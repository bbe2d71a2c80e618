//! Bellman's operator, straight from the definition: the reference for every kernel.

use crate::{GridWorld, Hop, Kind, Leaving};

/// The right-hand side of Bellman's equation at a free node under `values`, for each of the four hops in
/// the order of [`Hop::ALL`].
#[must_use]
pub fn action_values(world: &GridWorld, values: &[f64], node: usize) -> [f64; 4] {
    hop_values(world, node, |to| world.afterstate_value(values, to))
}

/// The values of the four hops at `node`, with the afterstate value of a node given by
/// `afterstate`.
pub(crate) fn hop_values(world: &GridWorld, node: usize, afterstate: impl Fn(usize) -> f64) -> [f64; 4] {
    let rules = world.rules();
    let wait = world.soil(node).wait;
    let here = afterstate(node);
    let lands = |hop| match (world.neighbour(node, hop), rules.leaving) {
        (Some(to), _) => afterstate(to),
        (None, Leaving::Stays) => here,
        (None, Leaving::Loses) => rules.loss,
    };
    let around = Hop::ALL.map(lands);
    Hop::ALL.map(|hop| {
        let scatter = world.scatter(node, hop);
        let next = scatter.intended * around[hop as usize]
            + scatter.stayed * here
            + scatter.left * around[hop.left() as usize]
            + scatter.right * around[hop.right() as usize];
        rules.discount * (wait * world.payoff(node) + (1.0 - wait + wait * rules.discount) * next)
    })
}

/// Residual |V − TV| at one node; 0 where the node is not free.
#[must_use]
pub fn residual(world: &GridWorld, values: &[f64], node: usize) -> f64 {
    if world.kind(node) != Kind::Free {
        return 0.0;
    }
    let best = action_values(world, values, node).into_iter().fold(f64::NEG_INFINITY, f64::max);
    // A value that is not a number must not pass for exact.
    if best.is_nan() || values[node].is_nan() { f64::INFINITY } else { (best - values[node]).abs() }
}
