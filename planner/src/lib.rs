//! Decides the hopper's next hop from what has been seen so far.
//!
//! All algorithms implement one trait, [`Planner`], and its law: a decision depends on the situation alone. A planner
//! knows the brief and the observed map, never the ground itself.

#![warn(clippy::disallowed_methods)]

pub mod algorithm;
pub mod belief;
pub mod error;
pub mod greedy;
pub mod hold;
pub mod mdp;
mod names;
pub mod payoff;
pub mod pilot;
pub mod plan;
pub mod process;
pub mod route;
#[cfg(feature = "shell")]
pub mod shell;
mod tie;

pub use algorithm::algorithm;
pub use error::PlannerError;
pub use names::{ALGORITHMS, CLAIRVOYANT};
pub use plan::{Budget, Plan, PlanStatus, Planner, Pulse, Situation};
