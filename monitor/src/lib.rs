//! Watches a mission from outside.
//!
//! [`Watcher`] folds public messages into [`Progress`], [`Chronicle`] into an account of every hop and cell: no
//! clock, file or port in them. [`display`] shows progress, [`web`] serves the account as a page, [`terminal`]
//! draws it, [`recorder`] writes the mission down; [`shell`] is the process around them.

pub mod chronicle;
pub mod display;
pub mod progress;
pub mod recorder;
pub mod shell;
pub mod terminal;
pub mod watcher;
pub mod web;

pub use chronicle::{Chronicle, News};
pub use display::Display;
pub use progress::{Health, Progress, Pulse};
pub use watcher::{Effect, Event, Watcher};
