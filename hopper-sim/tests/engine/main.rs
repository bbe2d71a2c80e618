//! Claims about the engine: dynamics, arbiter, journal, and what they promise together.

// Clippy takes the fixtures' functions for no tests.
#![allow(clippy::unwrap_used)]

mod arbiter;
mod chaos;
mod dynamics;
mod fixture;
mod journal;
mod linger;
mod resume;
mod truth;
mod verification;
mod wire;
