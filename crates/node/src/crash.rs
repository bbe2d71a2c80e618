//! Points at which a test may kill the process as `kill -9` would.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// `HOPPER_CRASH="name"` or `"name:n"`: die at the first, or the n-th, passage of that point.
const VARIABLE: &str = "HOPPER_CRASH";

struct Crash {
    point: String,
    /// Passages until the process dies.
    left: AtomicU64,
}

fn requested() -> Option<&'static Crash> {
    static REQUESTED: OnceLock<Option<Crash>> = OnceLock::new();
    REQUESTED
        .get_or_init(|| {
            let text = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty())?;
            let (point, left) = match text.rsplit_once(':') {
                Some((point, count)) => {
                    (point.to_owned(), count.parse().ok().filter(|&count| count > 0).unwrap_or(1))
                }
                None => (text, 1),
            };
            Some(Crash { point, left: AtomicU64::new(left) })
        })
        .as_ref()
}

/// Kills this process outright if `HOPPER_CRASH` names this passage of `name`; costs one load otherwise.
pub fn crash_point(name: &'static str) {
    let Some(crash) = requested() else { return };
    if crash.point == name && crash.left.fetch_sub(1, Ordering::Relaxed) == 1 {
        let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
        unreachable!("a process does not survive SIGKILL");
    }
}
