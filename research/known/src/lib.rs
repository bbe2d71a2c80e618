//! The planner of Sakamoto & Kubota 2022 (P22), which knows the whole map before the first hop.
//!
//! It is a crate of its own because knowledge must stop here: the planner process may see no ground but
//! what was sensed, so nothing in `planner` could hold this one; and no process uses it.
//!
//! A [`World`] is one of the paper's four; a [`Reading`] fixes what the paper leaves open; a [`Model`] is
//! the decision process that both make; [`solve`] is the paper's Algorithm 1; a [`Path`] follows the
//! policy's intended moves; [`execution`] draws what really happens. [`Findings`] are the paper's four
//! observations, claim by claim, and [`search`] finds the reading under which most of them hold.
//!
//! No clock, no file, no thread.

#![forbid(unsafe_code)]

mod claims;
mod error;
pub mod execution;
mod findings;
mod model;
mod path;
mod picture;
mod plan;
mod reading;
pub mod search;
mod solve;
mod world;

pub use claims::Claim;
pub use error::KnownError;
pub use findings::{Case, Findings};
pub use model::{Choice, Hop, Landing, Model};
pub use path::{Ending, Path};
pub use picture::{Figure, figure, figures};
pub use plan::{Plan, Weights};
pub use reading::{Edge, GoalPayoff, HalfHops, HillHeight, LongHops, Moment, P22, Reading, SandPayoff, Span};
pub use solve::{Solution, solve};
pub use world::{Experiment, Rocks, World};
