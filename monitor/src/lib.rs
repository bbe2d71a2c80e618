//! Watches a mission from outside.
//!
//! [`Watcher`] folds public messages into [`Progress`], [`History`] into every hop and cell: no clock,
//! file or port in them. [`mod@process`] is the work loop against ports, with the [`View`] that page and terminal
//! share. The shell has the command line and shared memory, `bar` shows progress, `web` serves the history as a page.
//! The terminal view and the recorder are crates of their own.

#![warn(clippy::disallowed_methods)]

#[cfg(feature = "shell")]
pub mod bar;
pub mod history;
pub mod process;
pub mod progress;
#[cfg(feature = "shell")]
pub mod record_args;
#[cfg(feature = "shell")]
pub mod shell;
pub mod view;
pub mod watcher;
pub mod web;

pub use history::{History, Input};
pub use progress::{Health, Progress, Pulse, TeamMeasure};
pub use view::{Screen, View, Wish};
pub use watcher::{Effect, Event, Watcher};
