//! Claims about the engine: dynamics, arbiter, journal, and what they promise together.

// Clippy takes the fixtures' functions for no tests.
#![allow(clippy::unwrap_used)]

mod arbiter;
mod chaos;
mod contact;
mod control;
mod displaced;
mod durability;
mod dynamics;
mod fixture;
mod formats;
mod ground;
mod guard;
mod journal;
mod linger;
mod mixed;
mod patrol;
mod resume;
mod scouts;
mod tampered;
mod truth;
mod verification;
mod vertical;
mod wire;
