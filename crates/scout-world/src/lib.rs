//! The true ground on which a rover drives and a helicopter looks ahead for it.
//!
//! [`World`] is the Monte Carlo world of Folsom et al. 2021, drawn for a seed; [`TrueGround`] is what a mission makes of any
//! ground with speeds. No planner may depend on this crate.

#![warn(clippy::disallowed_methods)]

mod stages;
mod true_ground;
mod world;

pub use routing::Trip;
pub use stages::{STAGE_SOL, StageClock};
pub use true_ground::{TrueGround, TrueGroundError, drive_speed, speed};
pub use world::{World, monte_carlo, monte_carlo_regions, readings};
