//! Watches a mission from outside.
//!
//! [`Watcher`] folds public messages into [`Progress`]: no clock, file or port in it. [`display`] shows
//! progress; [`shell`] is the process around both.

pub mod display;
pub mod progress;
pub mod shell;
pub mod watcher;

pub use display::Display;
pub use progress::{Health, Progress, Pulse};
pub use watcher::{Effect, Event, Watcher};
