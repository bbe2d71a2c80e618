//! How many cells of a profile agree with the paper, and which do not.

use contract::Profile;
use serde::Serialize;

use crate::cell_results::CellResults;
use crate::notation::{number, percent, spread, weights_in_brackets};
use crate::paper_comparison::PaperComparison;

/// The cells of one profile counted by their largest difference from the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Profile of the cells.
    pub profile: Profile,
    /// Cells within two standard errors.
    pub within_2: usize,
    /// Cells within five standard errors but not within two.
    pub within_5: usize,
    /// Cells beyond five standard errors.
    pub beyond: usize,
    /// One sentence for each cell beyond five standard errors.
    pub sentences: Vec<String>,
}

pub(crate) fn agreements(cells: &[CellResults<'_>]) -> Vec<Agreement> {
    let of_profile = |profile: Profile| {
        let mut agreement = Agreement { profile, within_2: 0, within_5: 0, beyond: 0, sentences: Vec::new() };
        for cell in cells.iter().filter(|cell| cell.profile == profile) {
            let Some(beside) = &cell.paper else { continue };
            match beside.difference_se() {
                Some(difference) if difference <= 2.0 => agreement.within_2 += 1,
                Some(difference) if difference <= 5.0 => agreement.within_5 += 1,
                Some(_) => {
                    agreement.beyond += 1;
                    agreement.sentences.push(sentence(cell, beside));
                }
                None => {}
            }
        }
        agreement
    };
    let compared = |agreement: &Agreement| agreement.within_2 + agreement.within_5 + agreement.beyond > 0;
    Profile::ALL.map(of_profile).into_iter().filter(compared).collect()
}

/// Which cell differs, by how much, and the known reason.
fn sentence(cell: &CellResults<'_>, beside: &PaperComparison) -> String {
    let mut parts = Vec::new();
    let statistics = &cell.statistics;
    if let Some(difference) = beside.success_difference_se.filter(|difference| difference.abs() > 5.0) {
        parts.push(format!(
            "succeeds in {} where the paper has {} % ({difference:+.1} standard errors)",
            percent(statistics.successes, statistics.trials),
            beside.successes
        ));
    }
    if let Some(difference) = beside.steps_difference_se.filter(|difference| difference.abs() > 5.0) {
        parts.push(format!(
            "needs {} steps where the paper has {} ({difference:+.1} standard errors)",
            spread(&statistics.steps),
            spread(&beside.steps)
        ));
    }
    let treasures = beside.treasures_difference_se.filter(|difference| difference.abs() > 5.0);
    if let (Some(difference), Some(papers)) = (treasures, &beside.treasures) {
        parts.push(format!(
            "collects {} treasures where the paper has {} ({difference:+.1} standard errors)",
            number(statistics.treasures.mean, 2),
            number(papers.mean, 2)
        ));
    }
    let why = match (cell.profile, beside.remark) {
        (Profile::Hopper, _) => "our planner's choices are not the paper's",
        (Profile::Paper2023, Some(remark)) => remark,
        (Profile::Paper2023, None) => "the paper does not say enough to tell why",
    };
    format!(
        "Table {}, {} {} {}: {}; {why}.",
        beside.table,
        cell.scenario,
        cell.planner,
        weights_in_brackets(&cell.weights),
        parts.join(" and ")
    )
}
