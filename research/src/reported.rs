//! What studies report.

use node::Failure;

use crate::report::Report;
use crate::studies::{Flown, FlownWorld};

/// A study that this program can report.
pub trait Reported: Flown {
    /// What it reports.
    type Report: Report;

    /// Pictures of one trial: names of files and SVG documents.
    ///
    /// # Errors
    /// As [`Flown::fly`].
    fn pictures(
        &self,
        ground: &Self::Ground,
        case: usize,
        seed: u64,
    ) -> Result<Vec<(String, String)>, Failure>;

    /// What the worlds come to; at least [`campaign::Study::WORLDS_MIN`] of them, in a campaign of seed `seed`.
    fn report(&self, seed: u64, worlds: &[FlownWorld<Self>]) -> Self::Report;
}
