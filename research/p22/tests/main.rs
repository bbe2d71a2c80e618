//! The rules, the search and the findings of P22.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod execution;
mod findings;
mod optimality;
mod rules;
mod search;
