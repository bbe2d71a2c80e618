//! Points at which a test may kill the process, as if by `kill -9`.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// `HOPPER_CRASH="name"` or `"name:n"`: die at the first, or the n-th, passage of that point.
const VARIABLE: &str = "HOPPER_CRASH";

struct Fuse {
    name: String,
    left: AtomicU64,
}

fn fuse() -> Option<&'static Fuse> {
    static FUSE: OnceLock<Option<Fuse>> = OnceLock::new();
    FUSE.get_or_init(|| {
        let text = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty())?;
        let (name, left) = match text.rsplit_once(':') {
            Some((name, count)) => {
                (name.to_owned(), count.parse().ok().filter(|&count| count > 0).unwrap_or(1))
            }
            None => (text, 1),
        };
        Some(Fuse { name, left: AtomicU64::new(left) })
    })
    .as_ref()
}

/// Kills this process outright if `HOPPER_CRASH` names this passage of `name`; costs one load otherwise.
pub fn crash_point(name: &'static str) {
    let Some(fuse) = fuse() else { return };
    if fuse.name == name && fuse.left.fetch_sub(1, Ordering::Relaxed) == 1 {
        let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
        unreachable!("a process does not survive SIGKILL");
    }
}
