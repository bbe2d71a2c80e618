//! Decides the hopper's next hop from what has been seen so far.
//!
//! Many algorithms behind one trait, [`Planner`]; each obeys its law, that a decision depends on the
//! situation alone. A planner knows the brief and the observed map, never the ground itself.

pub mod algorithm;
pub mod belief;
pub mod error;
pub mod greedy;
pub mod hold;
pub mod mdp;
pub mod payoff;
pub mod pilot;
pub mod plan;
pub mod process;
pub mod route;
#[cfg(feature = "shell")]
pub mod shell;
mod tie;

pub use algorithm::{ALGORITHMS, CLAIRVOYANT, algorithm};
pub use error::PlannerError;
pub use plan::{Budget, Plan, PlanStatus, Planner, Pulse, Situation};
