//! The processes in one thread, under a virtual clock and with every fault there is.
//!
//! [`simulation`] runs them with a plan of faults ([`fault`]): messages lost, doubled, late or out of order, processes killed or
//! stopped anywhere, a write to the journal cut at any byte, a full disk, rival planners, orders from a screen, a process
//! of another build, another mission in the midst of one, a loss of power, a wall clock that jumps. The checker
//! compares everything with the promises; then the faults stop, and the mission must end with the digest that lockstep
//! gives the same planners.
//!
//! The simulation implements `process::Ports`, so the work loops are the very functions that ship. No clock, file or thread:
//! `examples/seeds.rs` and the command `hopper simulate` run seeds side by side.
//!
//! Two clocks are told apart. Processes see CLOCK_MONOTONIC alone, which never jumps: it stands still with a sleeping
//! computer, and begins anew with a reboot, which nothing but the journal survives. The wall clock may jump as it likes;
//! the simulation lets it, to show that no process sees it.

#![warn(clippy::disallowed_methods)]

pub mod chance;
mod checker;
mod chosen;
mod claims;
pub mod coverage;
pub mod disk;
mod expected;
pub mod fault;
mod figures;
mod forgery;
mod life;
mod model;
mod observations;
mod observed;
mod offers;
mod oracle;
mod play;
mod ports;
mod recorded;
mod reservation;
mod route_memory;
mod routes;
mod screen;
mod sensor;
pub mod setup;
pub mod shrink;
pub mod simulation;
mod stamps;
pub mod stream;
mod tempo;
mod testing_model;
pub mod violation;
mod work_loops;
mod world;

pub use coverage::Sometimes;
pub use simulation::{Given, Report, simulate, simulate_given};
pub use work_loops::REASONS;
pub use world::Line;
