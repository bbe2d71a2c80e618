//! The named moments at which a test may kill hopper-sim.
//!
//! The machines are pure, so it is the process shell that passes these points to `node::crash_point`.

/// The journal is open, its header written if the run is new; nobody has heard of this life yet.
pub const JOURNAL_OPENED: &str = "sim.journal_opened";

/// The brief is published, the state is not.
pub const JOINED: &str = "sim.joined";

/// A command is accepted, its outcome drawn, its record about to be written. A life that ends here
/// has done nothing: the planner repeats the command, and the keyed draw gives the same outcome.
pub const BEFORE_APPEND: &str = "sim.before_append";

/// The journal holds the record: the hop has happened, though nobody has been told.
pub const APPENDED: &str = "sim.appended";

/// A state is published.
pub const PUBLISHED: &str = "sim.published";

/// Every crash point, in the order in which a life first passes them.
pub const CRASH_POINTS: &[&str] = &[JOURNAL_OPENED, JOINED, PUBLISHED, BEFORE_APPEND, APPENDED];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shell_passes_every_named_point_and_no_other() {
        let shell = include_str!("shell.rs");
        for point in CRASH_POINTS {
            let constant = point.strip_prefix("sim.").unwrap().to_uppercase();
            assert!(shell.contains(&format!("crash_point(crash::{constant})")), "{point} is passed");
        }
        assert_eq!(shell.matches("crash_point(crash::").count(), CRASH_POINTS.len());
    }
}
