//! One cell of a campaign compared with the cell that the paper published.

use campaign::statistics::{Sample, mean_difference, share_difference};
use campaign::tally::CellStatistics;
use serde::Serialize;

use crate::tables::{self, Published};

/// The published values of a cell, and how far ours are from them.
#[derive(Clone, Debug, Serialize)]
pub struct PaperComparison {
    /// Number of the table in the paper.
    pub table: u32,
    /// Successes of the paper's 100 trials.
    pub successes: u64,
    /// Steps of the paper's successful trials.
    pub steps: Sample,
    /// Our share of successes less the paper's, in standard errors under one pooled share.
    pub success_difference_se: Option<f64>,
    /// Our mean steps less the paper's, in standard errors (Welch).
    pub steps_difference_se: Option<f64>,
    /// Treasures collected by successes, where the paper counts them.
    pub treasures: Option<Sample>,
    /// Number of treasures with the number of successes that collected so many.
    #[serde(skip)]
    pub treasure_counts: &'static [(u64, u64)],
    /// Our mean treasures less the paper's, in standard errors (Welch).
    pub treasures_difference_se: Option<f64>,
    /// Known reason for a difference.
    pub remark: Option<&'static str>,
}

impl PaperComparison {
    pub(crate) fn new(published: &Published, statistics: &CellStatistics) -> Self {
        let ours = (statistics.successes, statistics.trials);
        Self {
            table: published.table,
            successes: published.successes,
            steps: published.steps(),
            success_difference_se: share_difference(ours, (published.successes, tables::TRIALS)),
            steps_difference_se: mean_difference(&statistics.steps, &published.steps()),
            treasures: published.treasures(),
            treasure_counts: published.treasures,
            treasures_difference_se: published
                .treasures()
                .and_then(|treasures| mean_difference(&statistics.treasures, &treasures)),
            remark: published.remark,
        }
    }

    /// Size of the largest difference, standard errors.
    #[must_use]
    pub fn difference_se(&self) -> Option<f64> {
        [self.success_difference_se, self.steps_difference_se, self.treasures_difference_se]
            .into_iter()
            .flatten()
            .map(f64::abs)
            .max_by(f64::total_cmp)
    }
}
