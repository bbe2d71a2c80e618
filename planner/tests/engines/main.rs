//! The planners held to the model, to their law, and to the paper's tables.

#![allow(clippy::unwrap_used, reason = "clippy knows #[test] functions, not what they call")]

mod certificate;
mod greedy;
mod independence;
mod law;
mod offers;
mod paper_table;
mod profile;
mod pulse;
mod route;
mod rows;
mod seen_ground;
mod treasures;
mod vetoes;
mod world;
