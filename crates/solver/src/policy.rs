//! The greedy hop under given values, with a total order among equals.

use crate::{GridWorld, Hop, Kind, action_values};

/// The first of north, east, south, west whose value lies within `tie` of the best; `None` where the node
/// is not free.
#[must_use]
pub fn hop(world: &GridWorld, values: &[f64], node: usize, tie: f64) -> Option<Hop> {
    (world.kind(node) == Kind::Free).then(|| first_best(action_values(world, values, node), tie))
}

/// The first of the four whose value lies within `tie` of the best.
#[must_use]
pub fn first_best(action_values: [f64; 4], tie: f64) -> Hop {
    let best = action_values.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let equal = |hop: &Hop| action_values[*hop as usize] >= best - tie;
    Hop::ALL.into_iter().find(equal).unwrap_or(Hop::North)
}
