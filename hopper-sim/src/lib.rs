//! The engine behind the process `hopper-sim`: true dynamics, the arbiter of who commands, the journal.
//!
//! [`Arbiter`] is a state machine without I/O: `on(event, now) -> effects`. Its hosts (process shell,
//! lockstep, tests) carry out the effects: append to the [`Journal`], publish, finish. The append is
//! the commit point of a hop; nothing is published that the journal does not hold. Folders on a disk are for Unix alone:
//! elsewhere, as in a browser, the engine has no journal on a disk.

#![warn(clippy::disallowed_methods)]

pub mod arbiter;
mod attachment;
#[cfg(feature = "shell")]
mod conversion;
pub mod crash;
pub mod dynamics;
#[cfg(feature = "shell")]
pub mod elevation_args;
mod execution;
mod exit;
pub mod file_error;
pub mod guard;
pub mod journal;
pub mod mission;
#[cfg(unix)]
pub mod private_file;
pub mod process;
mod record_store;
#[cfg(feature = "shell")]
pub mod shell;
pub mod team;
pub mod throttle;
mod trouble;

pub use arbiter::{Arbiter, Effect, Event, REPUBLISH_NS};
pub use attachment::Attachment;
pub use contract::Pace;
pub use crash::CRASH_POINTS;
pub use execution::Execution;
pub use guard::{Fallback, Guard};
pub use journal::{
    Journal, JournalError, JournalHeader, JournalReader, Located, Storage, Verification, verify,
};
pub use mission::{Mission, ROBOT};
pub use record_store::RecordStore;
pub use team::RobotTeam;
pub use throttle::Throttle;
