//! How busy the machine was: a number about time means nothing without it.

use contract::MonotonicNs;

/// The machine between two moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Host {
    /// Begin of the interval.
    pub since: MonotonicNs,
    /// End of the interval.
    pub until: MonotonicNs,
    /// Share of all cores that did any work, Hopper's own included, 0 to 1.
    pub busy: f64,
    /// The kernel's load average over a minute.
    pub load_1min: f64,
    /// Cores.
    pub cores: u32,
}
