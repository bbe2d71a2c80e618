//! Campaigns: a grid of missions, what became of each, and what they say together.
//!
//! A [`Campaign`] is read from TOML and laid out as a [`Plan`] of numbered [`Cell`]s. Each [`Trial`] of
//! the plan has a seed that follows from the campaign's seed, its cell and its repetition alone, so a
//! [`Row`] is the same whichever job, shard or resumption flew it. A [`Report`] folds rows in constant
//! memory and sets them beside the published tables of [`paper`].
//!
//! No threads, no clock; files are read by [`scenario::load`] only. The host flies the trials.

pub mod against;
pub mod cell;
pub mod comparison;
mod distribution;
pub mod error;
pub mod file;
pub mod manifest;
pub mod markdown;
mod number;
mod page;
pub mod paper;
pub mod plan;
mod records;
pub mod report;
pub mod row;
pub mod rows;
pub mod seal;
pub mod shard;
pub mod statistics;
pub mod tally;

pub use cell::Cell;
pub use comparison::Comparison;
pub use error::CampaignError;
pub use file::Campaign;
pub use manifest::Manifest;
pub use plan::{Plan, Trial};
pub use report::{Bound, Report};
pub use row::Row;
pub use rows::Rows;
pub use shard::Shard;
pub use tally::Tally;
