//! The whole system in one thread, with everything going wrong that may: what holds, and that the
//! simulation would notice if it did not.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod guarded;
mod planted;
mod undisturbed;
