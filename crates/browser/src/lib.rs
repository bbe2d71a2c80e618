//! A whole mission in one WebAssembly module, for the page without a server.
//!
//! hopper-sim, perception, planner and monitor take their turns in one thread on the ports of lockstep. A [`Session`] is a
//! mission that a page watches: it hands out the frames that the monitor's server would send. [`fly`] flies a mission at
//! once and tells its digest, which equals the one of the same mission on any other machine. `abi` is how JavaScript
//! calls both; `crates/browser/page/` is the JavaScript.

#![warn(clippy::disallowed_methods)]

#[cfg(target_arch = "wasm32")]
mod abi;
mod outcome;
mod request;
mod session;

pub use outcome::{Outcome, fly};
pub use request::{Request, Turnover};
pub use session::Session;
