//! Missions in one thread: robots of every kind, and planners from outside.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod accompanied;
mod coverage;
mod mixed;
mod own_planner;
mod rocks;
mod scouting;
