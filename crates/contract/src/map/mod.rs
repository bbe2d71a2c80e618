//! The ground: as it is, as it was known before, as it has been seen, and how all of that travels.

pub mod belief;
pub mod grid;
pub mod ground;
pub mod observed_map;
pub mod patch;
pub mod prior;
pub mod replica;
pub mod treasure;
pub mod truth;
