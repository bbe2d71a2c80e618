//! Wall time, processor time and memory of a solve.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

/// Solves are repeated until this much time has passed.
const LONG_ENOUGH: Duration = Duration::from_millis(500);
/// Most solves per run.
const SOLVES_MAX: usize = 101;

/// Times of repeated solves, seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Times {
    /// Wall-clock time of each repetition, seconds.
    pub wall_s: Vec<f64>,
    /// Processor time, all threads together.
    pub processor_s: Vec<f64>,
}

/// Runs `solve` once unmeasured if it is quick, then until half a second has passed or 101 times. It receives its last
/// result if that is `kept`; otherwise the result is dropped before, unmeasured.
pub fn repeat<T>(kept: bool, mut solve: impl FnMut(Option<T>) -> T) -> (Times, T) {
    let mut times = Times::default();
    let (wall_s, processor_s, first) = measure(|| solve(None));
    if wall_s >= LONG_ENOUGH.as_secs_f64() {
        times.wall_s.push(wall_s);
        times.processor_s.push(processor_s);
        return (times, first);
    }
    // The result of one solve must not count as memory of the next.
    let mut last = Some(first);
    let begin = Instant::now();
    while times.wall_s.is_empty() || (begin.elapsed() < LONG_ENOUGH && times.wall_s.len() < SOLVES_MAX) {
        let mut before = last.take();
        if !kept {
            before = None;
        }
        let (wall_s, processor_s, result) = measure(|| solve(before));
        times.wall_s.push(wall_s);
        times.processor_s.push(processor_s);
        last = Some(result);
    }
    (times, last.expect("a solve at least"))
}

fn measure<T>(solve: impl FnOnce() -> T) -> (f64, f64, T) {
    let (wall, processor) = (Instant::now(), processor_s());
    let result = solve();
    (wall.elapsed().as_secs_f64(), processor_s() - processor, result)
}

fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Largest resident size of this process so far, bytes; `None` where the system does not report it.
#[must_use]
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}
