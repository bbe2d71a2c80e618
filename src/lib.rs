//! The command `hopper`: missions as separate processes or in lockstep, and the commands around them.
//!
//! The programs beside it ([`tool`]) build on this library.

pub mod cli;
pub mod command_line;
pub mod commands;
pub mod files;
pub mod mission;
pub mod progress;
pub mod stdout;
pub mod tool;

/// Release and commit, as `hopper --version` prints them.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("HOPPER_COMMIT"), ")");

/// The commit this was built from, with `-dirty` after it if the work tree differed from it.
pub const COMMIT: &str = env!("HOPPER_COMMIT");
