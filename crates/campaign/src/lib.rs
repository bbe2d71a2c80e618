//! Campaigns: numbered trials, the rows that record them, and reports over them.
//!
//! A [`Campaign`] is read from TOML and becomes a [`Plan`] of numbered [`Cell`]s. The seed of each [`Trial`]
//! depends only on the campaign's seed, the cell and the repetition, so a [`Row`] is the same whichever job,
//! shard or resumption flew it. A [`Report`] folds rows in constant memory.
//!
//! A campaign may also name a [`Study`] in place of a grid. What its trials are and what it reports is known to whoever
//! implements that trait; files, plans and rows are those of [`study`]. Folders, shards and merging know only
//! [`TrialPlan`] and [`TrialRow`], which both kinds implement.
//!
//! No threads, no clock; files are read by [`scenario::load`] only. The caller flies the trials.

#![warn(clippy::disallowed_methods)]

pub mod cell;
pub mod cell_results;
pub mod checksum;
mod csv_records;
mod distribution;
pub mod error;
pub mod file;
pub mod manifest;
pub mod markdown;
mod markdown_report;
mod missions;
pub mod notation;
pub mod plan;
pub mod report;
pub mod row;
pub mod rows;
pub mod shard;
pub mod statistics;
pub mod study;
pub mod tally;
pub mod trial_plan;

pub use cell::Cell;
pub use cell_results::Bound;
pub use error::CampaignError;
pub use file::Campaign;
pub use manifest::Manifest;
pub use plan::{Plan, Trial};
pub use report::Report;
pub use row::Row;
pub use rows::Rows;
pub use shard::Shard;
pub use study::{Study, StudyFile, StudyPlan, StudyRow};
pub use tally::Tally;
pub use trial_plan::{TrialPlan, TrialRow};
