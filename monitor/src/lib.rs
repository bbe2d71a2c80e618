//! Watches a mission from outside.
//!
//! [`Watcher`] folds public messages into [`Progress`], [`History`] into every hop and cell; neither has a clock, file
//! or port. [`display`] prints progress, [`web`] serves the history as a page, [`terminal`] draws it, [`recorder`]
//! records the mission to a file. [`shell`] is the process around them.

pub mod display;
pub mod history;
pub mod progress;
pub mod recorder;
pub mod shell;
pub mod terminal;
pub mod watcher;
pub mod web;

pub use display::Display;
pub use history::{History, Input};
pub use progress::{Health, Progress, Pulse};
pub use watcher::{Effect, Event, Watcher};
