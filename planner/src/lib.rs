//! Decides the hopper's next hop from what has been seen so far.
//!
//! All algorithms implement one trait, [`Planner`], and its law: a decision depends on the situation alone. A planner
//! knows the brief and the observed map, never the ground itself.
//!
//! A program of one's own becomes a planner process by one line, and [`conformance::check`] holds its planner to the law:
//!
//! ```no_run
//! use planner::contract::{Action, Name};
//! use planner::{Budget, Plan, PlanStatus, Planner, Situation};
//!
//! #[derive(Default)]
//! struct Patient;
//!
//! impl Planner for Patient {
//!     fn name(&self) -> Name {
//!         "patient".parse().expect("a short and printable name")
//!     }
//!
//!     fn plan(&mut self, _: &Situation<'_>, _: &Budget) -> Plan {
//!         Plan::at_once(Action::Hold, PlanStatus::Solved)
//!     }
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     planner::main(Patient::default)
//! }
//! ```

#![warn(clippy::disallowed_methods)]

mod assignment;
mod built_in;
mod closed;
pub mod conformance;
pub mod cover;
pub mod drive;
pub mod error;
pub mod fly;
pub mod greedy;
pub mod hold;
pub mod mdp;
mod names;
mod offers;
mod others;
pub mod pilot;
pub mod plan;
pub mod process;
pub mod route;
#[cfg(feature = "shell")]
pub mod shell;
mod tie;
mod uncertain;
#[cfg(feature = "shell")]
mod usual;

pub use contract;

pub use assignment::assigned;
pub use built_in::{
    AHEAD_ALGORITHMS, ALGORITHMS, COVER_ALGORITHMS, DRIVE_ALGORITHMS, FLY_ALGORITHMS, algorithm, listed,
    suited, usual,
};
pub use contract::map::belief;
pub use contract::map::payoff;
pub use error::PlannerError;
pub use names::CLAIRVOYANT;
pub use plan::{Budget, Plan, PlanStatus, Planner, Pulse, Scouting, Situation};
#[cfg(feature = "shell")]
pub use shell::main;
