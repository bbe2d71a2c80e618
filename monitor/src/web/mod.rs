//! The monitor's web page.
//!
//! [`gate`] decides which requests are served, without sockets. [`shell`] has the sockets, a bounded number of them,
//! each in a thread of its own that reads the [`crate::History`] at its own speed: a slow or stalled client falls
//! behind, and nobody waits for it.

pub mod asset;
pub mod gate;
pub mod order;
#[allow(clippy::disallowed_methods, reason = "sockets, and a thread for each client")]
pub mod shell;

pub use gate::{Answer, Gate, Rejection};
pub use shell::{HISTORIES_MAX, POLICIES_MAX, Page};
