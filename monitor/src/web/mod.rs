//! The monitor's page.
//!
//! [`gate`] decides what a request may have: no socket in it. [`shell`] has the sockets, a bounded number of
//! them, each in a thread of its own that reads the [`crate::Chronicle`] at its own speed: a client that is slow
//! or stands still is behind, and nobody waits for it.

pub mod asset;
pub mod gate;
pub mod order;
pub mod shell;

pub use gate::{Answer, Gate, Rejection};
pub use shell::Page;
