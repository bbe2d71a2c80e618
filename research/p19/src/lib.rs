//! The study of Laîné & Yoshida 2019 (P19), whose rovers cover unknown ground.
//!
//! [`CASES`] are flown on random worlds, each to the shares of coverage that it is asked for. An
//! [`Account`] has the path ratios that the figures and claims of the paper need, and those of our
//! planner. `hopper coverage` makes claims, tables and pictures of it.
//!
//! No clock, no file, no thread.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

mod account;
mod case;
mod cases;
mod error;
mod estimate;
mod mission;
mod row;
mod steps;
pub mod stop_rule;

pub use account::{Account, Ours, Sampling, Sharing, row};
pub use case::{Case, Ground, PAPER};
pub use cases::{Asked, CASES, GROUNDS, OUR_TEAMS, PAIR_SIDES, PERCENTS, PLANNERS, SIDES, TEAMS};
pub use error::P19Error;
pub use estimate::{Estimate, Moments};
pub use mission::{fly, mission};
pub use row::Row;
pub use steps::Steps;
