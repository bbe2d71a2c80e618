//! The monitor's web page.
//!
//! [`order`] reads what the page asks for, also where nothing is served (`crates/browser`).
//! [`gate`] decides which requests are served, without sockets. [`shell`] has the sockets, a bounded number of them,
//! each in a thread of its own that reads the [`crate::History`] at its own speed: a slow or stalled client falls
//! behind, and nobody waits for it.

#[cfg(feature = "shell")]
pub mod asset;
#[cfg(feature = "shell")]
pub mod gate;
pub mod order;
#[cfg(feature = "shell")]
#[allow(clippy::disallowed_methods, reason = "sockets, and a thread for each client")]
pub mod shell;

#[cfg(feature = "shell")]
pub use gate::{Answer, Gate, Rejection};
#[cfg(feature = "shell")]
pub use shell::{HISTORIES_MAX, POLICIES_MAX, Page};
