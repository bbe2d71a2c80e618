//! The studies of Folsom et al. 2021 (P21): what a helicopter saves a rover, and what an agent learns on its way.
//!
//! Every arm of a study meets the same worlds with the same seeds: [`World`] is drawn, [`fly`] plans and drives it in each
//! [`Arm`], [`ArmEndings`] compare the travel times. [`LargeMap`] stands in for the paper's map of Jezero, [`SingleGrid`] is its small grid
//! for one agent.

#![warn(clippy::disallowed_methods)]

mod grid_mdp;
mod large;
mod mission;
mod scaled;
mod shown;
mod single;
mod study;

pub use helicopter::Sensor;

pub use grid_mdp::{GridMdp, GridValues, entropy_bits};
pub use large::{LARGE_SIDE, LargeMap};
pub use mission::{Arm, Outcome, RoverPlanner, Samples, Setup, Stage, announce, fly};
pub use scaled::monte_carlo_of;
pub use scout_world::{World, monte_carlo, monte_carlo_regions};
pub use shown::spread_shown;
pub use single::{CellType, Choice, GRID_SIDE, SingleGrid, simple_paths};
pub use study::{ArmEndings, Ending, Spread};
