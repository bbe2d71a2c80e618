//! Worlds whose hops land by a table: up to thirteen landings for each class of soil and slope.
//!
//! [`scatter`]'s law has four landings, all next to the hopper. Hops that bounce and roll have more, and farther ones: a
//! [`LandingTable`] holds them by class, in the frame of the hop, and a [`TableWorld`] says which class each hop at each node is of.
//! [`solve`] finds its values, with the same certificate as for a [`GridWorld`](crate::GridWorld).

mod solve;
mod table;
mod world;

pub use solve::{action_values, certify, solve};
pub use table::{Landing, LandingTable, Row};
pub use world::{TableRules, TableSite, TableWorld};
