//! The named moments at which a test may kill hopper-sim.
//!
//! The arbiter has no I/O, so the work loop passes these points: see [`process::Ports::pass`].

/// The journal is open, its header written if the run is new; nobody has heard of this life yet.
pub const JOURNAL_OPENED: &str = "sim.journal_opened";

/// The brief is published, the state is not.
pub const JOINED: &str = "sim.joined";

/// A command is accepted, its outcome drawn, its record about to be written. A life that ends here
/// has done nothing: the planner repeats the command, and the keyed draw gives the same outcome.
pub const BEFORE_APPEND: &str = "sim.before_append";

/// The journal holds the record: the hop has happened, though it is not published yet.
pub const APPENDED: &str = "sim.appended";

/// The journal could not take the record, and was cut back.
pub const APPEND_FAILED: &str = "sim.append_failed";

/// A state is published.
pub const PUBLISHED: &str = "sim.published";

/// Every crash point that each life passes, in the order in which it first does.
pub const CRASH_POINTS: &[&str] = &[JOURNAL_OPENED, JOINED, PUBLISHED, BEFORE_APPEND, APPENDED];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_loop_passes_every_named_point_and_no_other() {
        let code = [include_str!("shell.rs"), include_str!("process.rs")].concat();
        for point in CRASH_POINTS.iter().chain(&[APPEND_FAILED]) {
            let constant = point.strip_prefix("sim.").unwrap().to_uppercase();
            assert!(code.contains(&format!("pass(crash::{constant})")), "{point} is passed");
        }
        assert_eq!(code.matches("pass(crash::").count(), CRASH_POINTS.len() + 1);
    }
}
