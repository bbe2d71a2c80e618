//! Certified solutions of a grid world of hops.
//!
//! A [`GridWorld`] goes in: nodes on a grid, each with a payoff, a slope and a soil. The results are a value
//! for every node ([`Solver::values`]), a hop for every node ([`policy`]), and a [`Certificate`]: a bound on
//! the error of the values, computed by a sweep that shares no code with the kernels that found them. The
//! crate uses no clock, file or random number.
//!
//! ```
//! use solver::{Effort, GridWorld, Kind, Leaving, Rules, Soil, Solver, policy};
//!
//! let hard = Soil { intended: 0.9, stuck: 0.0, sideways: 0.05, wait: 0.0 };
//! let rules = Rules { discount: 0.99, loss: -100.0, leaving: Leaving::Loses, soils: vec![hard] };
//! let mut world = GridWorld::new(8, 5, rules)?;
//! let goal = 2 * 8 + 7;
//! world.set(goal, solver::Site { kind: Kind::Goal, payoff: 100.0, ..world.site(goal) });
//!
//! let mut solver = Solver::new();
//! let solution = solver.solve(&world, &Effort { error_max: 1e-9, sweeps_max: u64::MAX });
//! assert!(solution.certificate.error_bound <= 1e-9);
//! let start = 2 * 8;
//! assert_eq!(policy::hop(&world, solver.values(), start, 0.0), Some(solver::Hop::East));
//! # Ok::<(), solver::Error>(())
//! ```
//!
//! # The process
//! From a free node x the hopper chooses one of four hops u. With probabilities p(x′ | x, u), given by the
//! slope and the soil of x ([`scatter`], Sakamoto & Kunii 2023, section IV), it lands on the node ahead, stays
//! where it is, or slips to one of the two nodes beside. The *afterstate value* of landing on x′ is
//! w(x′) = r(x′) + V(x′) on free ground, r(x′) at a goal, and the loss where the hopper is lost. With γ the
//! discount and λ the share of hops from this soil that take a second period, spent at x,
//!
//! V(x) = (TV)(x) = max_u γ \[λ r(x) + (1 − λ + λγ) Σ p(x′ | x, u) w(x′)\].
//!
//! T contracts by γ in the maximum norm, so it has exactly one fixed point V*, and
//! |V − V*| ≤ max |V − TV| / (1 − γ) for any V. The certificate therefore does not depend on how V was found.
//!
//! # Modules
//! - [`cold`] solves a world from nothing: the whole map, to a bound on the error.
//! - [`online`] keeps the values of a world in step while its nodes change, and decides hop by hop.
//! - [`landings`] solves worlds whose hops land by a table, farther than to the next node.
//! - [`listed`] solves a world whose hops follow from no slope, from nothing and without special kernels.
//! - [`risk`] bounds the probability of being lost: least expected steps, undiscounted, with certified bounds.
//! - At the root is what they share: the world ([`grid_world`], [`soil`], [`hop`]), Bellman's operator from the
//!   definition ([`bellman`]), the bound ([`certificate`]), the greedy hop ([`policy`]), whether a goal can be
//!   reached ([`goal_search`]), the vector widths and instruction sets ([`simd`]), memory in huge pages
//!   (`pages`), and seeded worlds for tests and benchmarks ([`fixtures`]).
//!
//! # Tried and left out
//! For solves from nothing: a coarse grid to start from saved no more sweeps than it cost; extrapolation node by
//! node was never accepted; corrections by aggregates of nodes brought nine nodes in ten below the bound while
//! the largest error grew.

#![warn(clippy::disallowed_methods)]

pub mod bellman;
pub mod certificate;
pub mod cold;
pub mod error;
mod extent;
pub mod fixtures;
pub mod goal_search;
pub mod grid_world;
pub mod hop;
pub mod landings;
pub mod listed;
pub mod online;
mod pages;
pub mod policy;
pub mod risk;
pub mod simd;
pub mod soil;

pub use bellman::action_values;
pub use certificate::{Certificate, certify};
pub use cold::{Effort, Solution, SolveStatus, Solver};
pub use error::Error;
pub use goal_search::GoalSearch;
pub use grid_world::{GridWorld, Kind, Leaving, Rules, Site};
pub use hop::Hop;
pub use listed::{ListedHop, ListedWorld};
pub use scatter::Scatter;
pub use simd::Simd;
pub use soil::Soil;
