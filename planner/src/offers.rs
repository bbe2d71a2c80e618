//! The hops that a hopper is offered on the ground as believed: [`motion::offers`] on seen ground. Unseen ground is taken to block nothing.

use contract::map::belief::Belief;
use contract::{Action, Cell, Leg, ObservedMap};
use motion::Offer;

/// The hop towards each direction from `cell`, north, east, south, west; `None` where none is offered.
#[must_use]
pub fn offers(leg: &Leg, map: &ObservedMap, belief: &Belief<'_>, cell: Cell) -> [Option<Offer>; 4] {
    let height_m = |cell| map.ground(cell).map(|ground| ground.height_m);
    motion::offers(&leg.motion, &leg.grid, (cell, belief.ground(cell)), height_m)
}

/// The action towards each direction; hops at the launch angle where none is offered.
#[must_use]
pub fn actions(offers: &[Option<Offer>; 4]) -> [Action; 4] {
    contract::Direction::ALL
        .map(|direction| offers[direction as usize].map_or(Action::Hop(direction), |offer| offer.action))
}
