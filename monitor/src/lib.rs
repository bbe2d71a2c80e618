//! Watches a mission from outside.
//!
//! [`Watcher`] folds public messages into [`Progress`]: no clock, file or port in it. [`display`] shows
//! progress; [`recorder`] writes the mission down; [`shell`] is the process around them.

pub mod display;
pub mod progress;
pub mod recorder;
pub mod shell;
pub mod watcher;

pub use display::Display;
pub use progress::{Health, Progress, Pulse};
pub use watcher::{Effect, Event, Watcher};
