//! Campaigns of missions beside the tables of Sakamoto & Kunii 2023 (P23).
//!
//! [`tables`] has the published numbers. A [`PaperReport`] sets the cells of a campaign beside the
//! paper's. A [`Comparison`] judges the cells of one campaign beside those of another.
//! [`ReadingScores`] say how well each reading of the paper's open points fits its numbers.
//!
//! No clock, no file, no thread.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

mod agreement;
mod cell_beside_paper;
pub mod claim;
mod claims;
mod comparison;
mod csv_records;
mod markdown_report;
mod paper_comparison;
mod paper_report;
mod paper_tests;
mod range;
mod reading_scores;
pub mod tables;

pub use agreement::Agreement;
pub use cell_beside_paper::CellBesidePaper;
pub use comparison::{Comparison, Pair, REGRET_MAX, Verdict};
pub use paper_comparison::PaperComparison;
pub use paper_report::PaperReport;
pub use paper_tests::PaperTest;
pub use reading_scores::{CellScore, Choice, PooledDifference, ReadingScore, ReadingScores};
pub use tables::cell_episode_s;
