//! Processor time, so that what else runs on the machine counts little.

use rustix::time::{ClockId, clock_gettime};

/// Processor time of this process so far, seconds.
pub fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
