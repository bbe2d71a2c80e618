//! What a mission is about: its brief, its robots, their task, and what landings are worth.

pub mod brief;
pub mod pace;
pub mod patrol;
pub mod payoff;
pub mod reading;
pub mod task;
pub mod team;
