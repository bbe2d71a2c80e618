//! The best that any planner can do: finite-horizon dynamic programming on the true map.
//!
//! It reads the truth, so it is a yardstick and never a process: no shell depends on this crate.
//!
//! With k steps left at x and c the cost of a hop's branch in the paper's count ([`motion::steps`]), two
//! bounds are solved for, each on its own, for no one plan need reach both:
//!
//! - success, P_k(x) = max_u Σ p P_{k−c}(x′), 1 at the goal in time, 0 once late, off the map or lost;
//! - restricted mean steps, M_k(x) = min_u Σ p (c + M_{k−c}(x′)), a failure counted at the limit: k in
//!   all, whenever it comes.
//!
//! Treasures are no part of either bound: what is bounded is the way to the goal.
//!
//! Holding never helps: both are monotone in k (P_k ≥ P_{k−1}, M_k ≤ M_{k−1} + 1), since whatever can
//! be done with fewer steps can be done with more.

#![forbid(unsafe_code)]

mod horizon;
mod planner_of_truth;

pub use horizon::{Bounds, bounds};
pub use planner_of_truth::{Clairvoyant, ClairvoyantError, TABLE_MAX};
