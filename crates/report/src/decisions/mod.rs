//! Where the time of each decision went, which missed its budget, and what explains it.
//!
//! Used by `hopper latency report`. [`crate::Latency`] folds a mission of any length in constant memory;
//! [`DecisionTimings`] keeps every decision, so that the longest can be named.

mod cause;
mod compare;
mod plot;
mod report;
mod timing;
mod timings;

pub use cause::{Cause, Disturbance};
pub use compare::{TimingComparison, compare};
pub use plot::plot;
pub use report::{Conditions, DecisionReport, Group, StageTimes, Worst};
pub use timing::{DecisionTiming, boot_began};
pub use timings::DecisionTimings;
