//! Who a pilot is.

use contract::{Incarnation, Name, RobotSet};

/// Who this planner is, and what it may presume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PilotConfig {
    /// The robots that it may command.
    pub robots: RobotSet,
    /// Tells this life of the process from earlier ones.
    pub incarnation: Incarnation,
    /// This process; 0 in lockstep.
    pub pid: u32,
    /// Algorithm, as heartbeats and records name it.
    pub planner: Name,
    /// Take the next term from a living leader, once.
    pub takeover: bool,
    /// A process known to be dead: its term may be taken at once.
    pub succeeds_pid: Option<u32>,
}
