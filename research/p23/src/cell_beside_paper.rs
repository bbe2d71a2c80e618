//! The results of one cell beside those of the paper.

use campaign::cell_results::CellResults;
use contract::MotionModel;
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
    /// Compares `results` with the paper's cell, if it has one: papers fly under the law alone.
    #[must_use]
    pub fn compared(results: &'a CellResults<'a>) -> Self {
        let published = if results.dynamics == MotionModel::Law {
            tables::published(results.scenario, results.planner, &results.weights)
        } else {
            None
        };
        let paper = published.map(|published| PaperComparison::new(&published, &results.statistics));
        Self { results, paper }
    }
}

#[cfg(test)]
mod tests {
    use campaign::tally::Tally;
    use contract::{Profile, Weights};

    use super::*;

    #[test]
    fn a_cell_is_compared_with_the_paper_only_where_its_hops_end_as_the_papers() {
        let is_compared = |dynamics| {
            let results = CellResults {
                scenario: "treasures",
                profile: Profile::Hopper,
                planner: "mdp",
                weights: Weights { safety: 0.0, information: 1.0, distance: 10.0 },
                reading: None,
                dynamics,
                steps_max: 150,
                statistics: Tally::default().statistics(150),
                regret: None,
            };
            CellBesidePaper::compared(&results).paper.is_some()
        };
        assert!(is_compared(MotionModel::Law));
        assert!(!is_compared(MotionModel::Collision) && !is_compared(MotionModel::Contact));
    }
}
