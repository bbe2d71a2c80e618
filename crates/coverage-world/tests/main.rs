//! Rovers on unknown ground: the paper's rule, what a team keeps to, and what no decision depends on.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod paper_rule;
mod shorter;
mod team;
mod unsensed;
