//! Proof that a work loop still turns.

use serde::{Deserialize, Serialize};

use crate::{Decision, Incarnation, Name, RobotSet, Role, RunId, Status};

/// Most beats at once: how far ahead of the last a beat may be without any time gone by.
const LEAP_BEATS: u64 = 1_000;

/// A process never beats more often than that, fifty times as often as it should.
const BEAT_PERIOD_MIN_NS: u64 = 1_000_000;

/// One beat. It counts only if [`Heartbeat::counter`] has advanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heartbeat {
    /// Part the process plays.
    pub role: Role,
    /// Life of the process.
    pub incarnation: Incarnation,
    /// Operating-system process, for the reader of a log: a number may be used again.
    pub pid: u32,
    /// Version of its build.
    pub version: Name,
    /// Algorithm of a planner; [`Name::NONE`] otherwise.
    pub planner: Name,
    /// Beats of this life.
    pub counter: u64,
    /// Run it last saw; 0 for none.
    pub run: RunId,
    /// Decision it last saw.
    pub decision: Decision,
    /// Status it last saw.
    pub status: Status,
    /// Of a planner the robots that it plans for, none if it cannot plan for the mission it knows; of hopper-sim the robots
    /// that still act, so that somebody has to plan for them; none of other roles.
    pub robots: RobotSet,
}

impl Heartbeat {
    /// Whether it is the next sign of a life whose `last` beat was heard `since_ns` nanoseconds ago: its counter
    /// neither stands still nor leaps. One that leaps is somebody else's forgery; taken at its word, it would
    /// silence the life it names for ever.
    #[must_use]
    pub fn follows(&self, last: &Heartbeat, since_ns: u64) -> bool {
        let ahead_max = LEAP_BEATS + since_ns / BEAT_PERIOD_MIN_NS;
        (1..=ahead_max).contains(&self.counter.saturating_sub(last.counter))
    }
}
