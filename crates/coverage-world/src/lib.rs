//! The true ground of a coverage mission, with whole missions on it in one function.
//!
//! A [`World`] is a grid with obstacles; only this crate knows it. A [`Mission`] lets the rovers of a [`Setup`] act in
//! the order of their numbers until the ground is covered: it shows them what their sensors may see and asks the
//! planners of the crate `coverage`.
//!
//! No I/O, no clock, no thread. Random numbers are keyed by seed and purpose.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

mod draw;
pub mod error;
pub mod mission;
pub mod progress;
pub mod reachable;
pub mod sensing;
pub mod setup;
pub mod world;

pub use error::{SetupError, WorldError};
pub use mission::{Mission, Outcome};
pub use progress::Progress;
pub use sensing::Sensing;
pub use setup::{Fault, Setup};
pub use world::World;
