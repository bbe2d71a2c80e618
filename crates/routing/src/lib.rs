//! Routes for a rover on uncertain ground, with flights for the helicopter that scouts for it.
//!
//! | planner | for | from |
//! | --- | --- | --- |
//! | [`rrt_star`](fn@rrt_star) | rover: shortest way, whatever the risk | Folsom et al. 2021 |
//! | [`rrt_star_ett`] | rover: least expected travel time (ETT) on safe ground | Folsom et al. 2021 |
//! | [`ett_exact`](fn@ett_exact) | the same, searched completely, with [`lower_bound`](fn@lower_bound) | |
//! | [`scout_route`](fn@scout_route) | helicopter: along the rover's route | Folsom et al. 2021 |
//! | [`rrt_star_it`](fn@rrt_star_it) | helicopter: where speeds are spread most | Folsom et al. 2021 |
//! | [`scout_value`](fn@scout_value) | helicopter: where knowing helps the rover most | |
//!
//! A planner's random numbers come from the seed it is given, never from the simulator's.

#![warn(clippy::disallowed_methods)]

mod bucket_grid;
mod ett_exact;
mod kept_clear;
mod lower_bound;
mod route;
mod rrt_star;
mod rrt_star_it;
mod scout_route;
mod scout_value;
mod shorten;
mod stream;

pub use bucket_grid::BucketGrid;
pub use ett_exact::{ett_exact, ett_exact_or_closer, graph_route};
pub use kept_clear::KeptClear;
pub use lower_bound::lower_bound;
pub use route::{Goal, Route, Trip};
pub use rrt_star::{RrtStar, rrt_star, rrt_star_ett};
pub use rrt_star_it::{RrtStarIt, rrt_star_it};
pub use scout_route::scout_route;
pub use scout_value::{ScoutValue, scout_value};
pub use shorten::{pull_tight, random_shortcuts};
pub use stream::{Stream, stage_seed};
