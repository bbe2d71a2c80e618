//! What the hopper has seen of its world, and nothing more.
//!
//! [`sensing`] says which cells a pose reveals, [`observation`] what is then known of them, and
//! [`cartographer`] is the state machine that folds poses into the map and publishes it. [`process`] is
//! its work loop against ports; the shell gives it shared memory and the clock.
//!
//! The map is a pure fold over public messages: the same poses give the same map, whoever died in
//! between.

#![warn(clippy::disallowed_methods)]

pub mod cartographer;
pub mod observation;
pub mod process;
pub mod sensing;
#[cfg(feature = "shell")]
pub mod shell;
mod tracks;

pub use cartographer::{Cartographer, Effect, Event};
pub use observation::Observation;
use tracks::Tracks;
