//! What the arbiter receives, and what it wants done.

use contract::{Announcement, Command, Control, Heartbeat, Policy, Record, Refusal, State, Status};

use crate::guard::Fallback;

/// What the arbiter receives.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// A command came, or a message that was none.
    Command(Result<Command, Refusal>),
    /// A command of a life of which no heartbeat has been heard. It is judged like any other, but neither executed nor
    /// is a decision kept for it: it may be of another build, and is sent again.
    Stranger(Command),
    /// The points of a route came that a command may announce, or a message that was none.
    Announcement(Result<Announcement, Refusal>),
    /// The journal holds the record of the last [`Effect::Append`].
    Appended,
    /// The journal could not take the record of the last [`Effect::Append`].
    AppendFailed,
    /// A peer's heartbeat came.
    Heartbeat(Heartbeat),
    /// An order came, or a message that was none.
    Control(Result<Control, Refusal>),
    /// A planner's policy came; the last one is kept for the fallback.
    Policy(Policy),
    /// What the fallback did at the decision that is due when this mission was flown before: done again, as
    /// recorded. Deadlines pass by the clock, so a mission that is repeated goes by its journal.
    Repeat(Fallback),
    /// A message that is no command was malformed: it is counted, and nothing else.
    Refused(Refusal),
    /// Time has passed; the first publishes the state, and is the landing it tells of.
    Tick,
}

/// What the arbiter wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Append this record, then answer [`Event::Appended`] or [`Event::AppendFailed`].
    Append(Record),
    /// Publish the brief again: a peer does not know of this run.
    Announce,
    /// Tell everyone; only after its record is in the journal.
    Publish(State),
    /// Tell of a refused command; it is counted already.
    Refused(Refusal),
    /// The mission is over and everyone knows, or has been waited for. Comes once.
    Finished(Status),
}
