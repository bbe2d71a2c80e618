//! The monitor's web page.
//!
//! [`order`] reads what the page asks for, also where nothing is served (`crates/browser`).
//! [`gate`] decides which requests are served, without sockets, by the names of a server ([`hosts`]). [`reception`] reads
//! requests in one thread, for the page and for other servers of the monitor. [`shell`] answers them: each event stream has a
//! thread of its own that reads the [`crate::History`] at its own speed, so a slow or stalled client falls behind, and nobody
//! waits for it. [`places`] bounds their number, and decides who makes room when all places are taken.

#[cfg(feature = "shell")]
pub mod asset;
#[cfg(feature = "shell")]
pub mod gate;
#[cfg(feature = "shell")]
pub mod head;
#[cfg(feature = "shell")]
pub mod hosts;
pub mod order;
#[cfg(feature = "shell")]
pub mod places;
#[cfg(feature = "shell")]
#[allow(clippy::disallowed_methods, reason = "sockets, and a thread that reads them")]
pub mod reception;
#[cfg(feature = "shell")]
mod redirect_file;
#[cfg(feature = "shell")]
pub mod rejection;
#[cfg(feature = "shell")]
#[allow(clippy::disallowed_methods, reason = "sockets, and a thread for each client")]
pub mod shell;

#[cfg(feature = "shell")]
pub use gate::{Answer, Gate};
#[cfg(feature = "shell")]
pub use head::Head;
#[cfg(feature = "shell")]
pub use hosts::Hosts;
#[cfg(feature = "shell")]
pub use places::{HISTORIES_MAX, POLICIES_MAX};
#[cfg(feature = "shell")]
pub use reception::{Reception, Served, Service};
#[cfg(feature = "shell")]
pub use rejection::Rejection;
#[cfg(feature = "shell")]
pub use shell::Page;
