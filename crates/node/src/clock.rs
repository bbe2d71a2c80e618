//! The host's monotonic clock.

use contract::MonotonicNs;
use rustix::time::{ClockId, clock_gettime};

/// Now on CLOCK_MONOTONIC, which all processes of the host share.
#[must_use]
pub fn now() -> MonotonicNs {
    let now = clock_gettime(ClockId::Monotonic);
    MonotonicNs(now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64)
}
