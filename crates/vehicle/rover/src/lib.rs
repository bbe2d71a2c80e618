//! A rover that drives on ground whose speed is known only as a probability.
//!
//! The model is that of Folsom et al. 2021, "Scalable information-theoretic path planning for a rover-helicopter team in
//! uncertain environments". Lengths are in metres, times in Sol, and cells are squares of one metre.
//!
//! The order of reading: [`SpeedDistribution`] is what is known of a cell, [`Belief`] of all cells, [`CostMap`] what a planner
//! makes of it, [`drive()`] what happens on the true ground. Planner and truth cut an edge into cells with the same [`traverse`].

#![warn(clippy::disallowed_methods)]

mod belief;
mod cost_map;
mod drive;
mod lattice;
mod mobility;
mod speed;
mod surface;
mod traverse;

pub use belief::{Belief, BeliefError, Caution, Truth};
pub use cost_map::CostMap;
pub use drive::{Allowance, Drive, DriveEnd, drive};
pub use lattice::{Lattice, LatticeError, Point};
pub use mobility::{MobilityError, TerrainClass, speed, speed_distribution};
pub use speed::{Speed, SpeedDistribution, SpeedError};
pub use surface::{Surface, SurfaceError};
pub use traverse::{SLIVER_M, Segment, traverse};

/// Hours of one Sol, as the paper rounds it.
pub const SOL_HOURS: f64 = 24.66;
