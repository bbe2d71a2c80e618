//! Damaged, extreme, rewritten and mutated input.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod corpus;
mod damage;
mod extremes;
mod rewritten;
