//! The solve from nothing: values of a whole world to a certified bound, or to the end of a budget.
//!
//! [`solve`] holds the order of events. The mathematics is explained where it is used:
//!
//! - the kernel's form of Bellman's operator, with one division per node: `sweep`;
//! - the layout in which a diagonal of the grid is updated at once, with the result of updating node by node:
//!   `skew`; what the world holds for the nodes of a chunk: `gather`; the planes of numbers in that layout:
//!   `planes`, which begin at a cache line: `plane`;
//! - the order of updates, many sweeps in one wavefront: `wavefront`; two threads in one wavefront: `pair`;
//! - the residual of each hop in double precision: `residual`;
//! - the correction, by sweeps of the shifted operator (`sweep`), or, where the hopper lingers, by Newton's step
//!   for Bellman's equation: `correct`, by a Krylov method where its sweeps are slow: `krylov`;
//! - the certificate's own sweep: `measure`.
//!
//! # Terms
//! - **Chunk**: 16 nodes of a diagonal, side by side in memory, updated together. **Lane**: a node's position
//!   in its chunk. **Entry**: a node's index in a plane.
//! - **Halo**: the entries one node beyond the border of the grid, which hold what leaving it is worth.
//! - **Lingering**: in some worlds the best policy never goes to the goal, because staying on a hill pays more.
//!   Sweeps converge slowly there.

mod correct;
mod gather;
mod krylov;
mod measure;
mod pair;
mod plane;
mod planes;
mod residual;
mod skew;
pub mod solve;
mod sweep;
mod wavefront;

pub use solve::{Effort, Solution, SolveStatus, Solver};
