//! The Monte Carlo study of Folsom et al. 2021: what a helicopter saves a rover.
//!
//! Every arm of the study meets the same worlds with the same seeds: [`World`] is drawn, [`fly`] plans and drives it in each
//! [`Arm`], [`Study`] compares the travel times.

#![warn(clippy::disallowed_methods)]

mod mission;
mod study;

pub use mission::{Arm, Outcome, RoverPlanner, Samples, announce, fly};
pub use scout_world::{World, monte_carlo, monte_carlo_regions};
pub use study::{Spread, Study};
