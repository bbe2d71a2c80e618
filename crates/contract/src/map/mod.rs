//! What is known of the ground: the map as it grows, how it travels, and what a landing on it is worth.

pub mod belief;
pub mod observed_map;
pub mod patch;
pub mod payoff;
pub mod prior;
pub mod truth;
