//! The results of one cell beside those of the paper.

use campaign::cell_results::CellResults;
use serde::Serialize;

use crate::paper_comparison::PaperComparison;
use crate::tables;

/// The results of one cell beside the paper's. Serialised, the results are fields of the cell itself.
#[derive(Clone, Debug, Serialize)]
pub struct CellBesidePaper<'a> {
    /// Our results.
    #[serde(flatten)]
    pub results: &'a CellResults<'a>,
    /// Comparison with the paper's cell; `None` if there is none or it was not asked for.
    pub paper: Option<PaperComparison>,
}

impl<'a> CellBesidePaper<'a> {
    /// Compares `results` with the paper's cell, if it has one.
    #[must_use]
    pub fn compared(results: &'a CellResults<'a>) -> Self {
        let published = tables::published(results.scenario, results.planner, &results.weights);
        let paper = published.map(|published| PaperComparison::new(&published, &results.statistics));
        Self { results, paper }
    }
}
