//! How busy the machine was, to put recorded times into context.

use contract::MonotonicNs;

/// Load of the machine over an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineLoad {
    /// Begin of the interval, on CLOCK_MONOTONIC.
    pub since: MonotonicNs,
    /// End of the interval, on CLOCK_MONOTONIC.
    pub until: MonotonicNs,
    /// Share of all cores that was busy, Hopper's own work included, 0 to 1.
    pub busy: f64,
    /// One-minute load average of the kernel, 0 to 1,000,000.
    pub load_1min: f64,
    /// Logical ones, as the scheduler counts them.
    pub cores: u32,
}
