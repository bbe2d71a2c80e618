//! The planner of Sakamoto & Kubota 2022 (P22), which knows the whole map before the first hop.
//!
//! It is a crate of its own because a planner process may use only what was sensed, while this planner takes the
//! whole map. No process depends on it.
//!
//! A [`KnownMap`] is one of the paper's four maps; a [`Reading`] fixes what the paper leaves open; a [`Model`] is
//! the decision process of a map under a reading; [`solve`] is the paper's Algorithm 1; a [`Path`] follows the
//! intended hops of a policy; [`execution`] draws actual hops. [`Findings`] checks the paper's four observations
//! claim by claim, and [`search`] finds the reading under which most claims hold.
//!
//! No clock, no file, no thread.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

mod case;
mod claims;
mod error;
pub mod execution;
mod findings;
mod known_map;
mod model;
mod path;
mod picture;
mod plan;
mod reading;
pub mod search;
mod solve;
mod weights;

pub use case::Case;
pub use claims::Claim;
pub use error::KnownError;
pub use findings::Findings;
pub use known_map::{Experiment, KnownMap};
pub use model::{Choice, Hop, Landing, Model};
pub use path::{Path, PathEnd};
pub use picture::{Figure, figure, figures};
pub use plan::Plan;
pub use reading::{
    Edge, GoalPayoff, HalfHops, HillHeight, LongHops, P22, PayoffCell, Reading, SandPayoff, Span,
};
pub use solve::{Solution, solve};
pub use weights::Weights;
