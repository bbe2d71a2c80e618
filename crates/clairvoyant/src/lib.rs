//! The best that any planner can do, by finite-horizon dynamic programming on the true map.
//!
//! The crate reads the true map, so it serves as a reference only, and no process depends on it.
//!
//! With k steps left at x and c the cost of a hop's branch in the paper's count ([`motion::steps`]), two
//! bounds are computed, each on its own, since one plan need not reach both:
//!
//! - success, P_k(x) = max_u Σ p P_{k−c}(x′), 1 at the goal in time, 0 once late, off the map or lost;
//! - restricted mean steps, M_k(x) = min_u Σ p (c + M_{k−c}(x′)), a failure counted at the limit: k in
//!   all, whenever it comes.
//!
//! Treasures are not part of either bound, which concern only reaching the goal.
//!
//! Holding never helps: both are monotone in k (P_k ≥ P_{k−1}, M_k ≤ M_{k−1} + 1), because any plan for fewer steps also
//! fits into more.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

mod clairvoyant_planner;
mod horizon;

pub use clairvoyant_planner::{Clairvoyant, ClairvoyantError, TABLE_MAX};
pub use horizon::{Bounds, bounds};
