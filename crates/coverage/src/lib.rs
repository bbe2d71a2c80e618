//! Planners for rovers that cover unknown ground while each sees only the cells around it.
//!
//! Home of the decision rule of Laîné & Yoshida 2019 (P19): [`rule`] has its two patterns with their costs (eq. 1),
//! [`region`] its two ways to share the ground. [`frontier`] is our own planner, which goes to the nearest uncovered
//! ground. All decide from a [`Situation`]: what the team has sensed ([`TeamMap`]), how often each cell was visited,
//! and where the rovers are.
//!
//! The true ground is in the crate `coverage-world`, which depends on this one: nothing here can name an unsensed cell's
//! content. A decision is a function of the situation alone; what a [`Planner`] keeps between calls is memory to reuse.
//!
//! No I/O, no clock, no thread, no random number.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

pub mod algorithm;
pub mod frontier;
pub mod region;
pub mod rule;
pub mod situation;
pub mod team_map;

pub use algorithm::{Algorithm, Planner, UnknownAlgorithm};
pub use contract::{CoverMode, Placement};
pub use situation::{Rover, Situation};
pub use team_map::{Knowledge, TeamMap};
