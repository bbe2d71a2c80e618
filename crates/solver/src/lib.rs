//! Certified solutions of a grid world of hops.
//!
//! A [`World`] goes in: nodes on a grid, each with a payoff, a slope and a soil. Out come a value for
//! every node ([`Solver::values`]), a hop for every node ([`policy`]), and a [`Certificate`]: a bound on
//! how far the values are from the true ones, measured by a sweep that shares nothing with the kernels
//! that made them. No clock, no file, no random number.
//!
//! # The process
//! From a free node x the hopper chooses one of four hops u. With probabilities p(x′ | x, u), given by
//! the slope and the soil of x ([`World::scatter`]; Sakamoto & Kunii 2023, section IV), it comes down on
//! the node ahead, stays where it is, or slips to one of the two nodes beside. The worth of landing on x′
//! is w(x′) = r(x′) + V(x′) on free ground, r(x′) at a goal, and the loss where the hopper is lost. With
//! γ the discount and λ the share of hops from this soil that take a second period, spent at x,
//!
//! V(x) = (TV)(x) = max_u γ \[λ r(x) + (1 − λ + λγ) Σ p(x′ | x, u) w(x′)\].
//!
//! T contracts by γ in the maximum norm, so its fixed point V* exists, is the only one, and
//! |V − V*| ≤ max |V − TV| / (1 − γ) for any V: the certificate needs no knowledge of how V was found.
//!
//! # From nothing
//! [`solve`] is the order of events. The mathematics stand where they are used:
//!
//! - the kernel's form of Bellman's operator, one division a node: `sweep`;
//! - the layout in which a diagonal of the grid is updated at once, as if node by node: `skew`; what the world has of
//!   its nodes: `gather`;
//! - the order of updates, many sweeps in one wave: `wave`; two threads in one wave: `pair`;
//! - what large planes lie in: `pages`;
//! - the survey in double precision, what each hop is short of: `survey`;
//! - the correction by sweeps of the operator shifted (`sweep`), or Newton's step for Bellman's equation by a
//!   Krylov method where there is somewhere to linger: `correct`;
//! - the certificate's own sweep: `measure`;
//! - why every instruction set gives the same bits: [`simd`].
//!
//! A coarse grid to start from was tried, as were per-node extrapolation and corrections by aggregates of
//! nodes: the first saved no more sweeps than it cost, the second was never accepted, the third brought nine
//! nodes in ten below the bound, and the largest error grew.

pub mod bellman;
pub mod certificate;
mod correct;
pub mod error;
mod extent;
mod gather;
pub mod hop;
mod measure;
pub mod online;
mod pages;
mod pair;
mod plane;
pub mod policy;
pub mod reach;
pub mod simd;
mod skew;
pub mod soil;
pub mod solve;
pub mod specimen;
mod survey;
mod sweep;
mod wave;
pub mod world;

pub use bellman::action_values;
pub use certificate::{Certificate, certify};
pub use error::Error;
pub use hop::Hop;
pub use reach::Reach;
pub use simd::Simd;
pub use soil::Soil;
pub use solve::{Effort, Solution, Solver, Status};
pub use world::{Kind, Leaving, Rules, Scatter, Site, World};
