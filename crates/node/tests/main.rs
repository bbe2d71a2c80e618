//! Instances, ports and processes over real shared memory.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on has failed; parts tell each other"
)]

mod instance;
mod ports;
mod processes;
mod samples;
