//! How many cells of a profile agree with the paper, and which do not.

use campaign::cell_results::CellResults;
use campaign::notation::{number, percent, spread, weights_in_brackets};
use contract::Profile;
use serde::Serialize;

use crate::cell_beside_paper::CellBesidePaper;
use crate::paper_comparison::PaperComparison;

/// The scenario whose map the paper does not give.
const LARGE_MAP: &str = "large";

/// The cells of one profile counted by their largest difference from the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Profile of the cells.
    pub profile: Profile,
    /// Their reading of the paper's open points, in a campaign that compares some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reading: Option<String>,
    /// Whether they are those of the large map, which is another than the paper's.
    pub large_map: bool,
    /// Cells within two standard errors.
    pub within_2: usize,
    /// Cells within five standard errors but not within two.
    pub within_5: usize,
    /// Cells beyond five standard errors.
    pub beyond: usize,
    /// One sentence for each cell beyond five standard errors.
    pub sentences: Vec<String>,
}

/// Of each profile and reading, the cells that can be reproduced, and those of the large map.
pub(crate) fn agreements(cells: &[CellBesidePaper<'_>]) -> Vec<Agreement> {
    let mut agreements: Vec<Agreement> = Vec::new();
    for CellBesidePaper { results: cell, paper } in cells {
        let Some(beside) = paper else { continue };
        let Some(difference) = beside.difference_se() else { continue };
        let large_map = cell.scenario == LARGE_MAP;
        let is_of = |agreement: &Agreement| {
            (agreement.profile, agreement.reading.as_deref(), agreement.large_map)
                == (cell.profile, cell.reading, large_map)
        };
        let agreement = match agreements.iter().position(is_of) {
            Some(place) => &mut agreements[place],
            None => {
                agreements.push(Agreement::of(cell, large_map));
                agreements.last_mut().expect("just pushed")
            }
        };
        match difference {
            ..=2.0 => agreement.within_2 += 1,
            ..=5.0 => agreement.within_5 += 1,
            _ => {
                agreement.beyond += 1;
                agreement.sentences.push(sentence(cell, beside));
            }
        }
    }
    agreements.sort_by_key(|agreement| (agreement.profile, agreement.large_map));
    agreements
}

impl Agreement {
    fn of(cell: &CellResults<'_>, large_map: bool) -> Self {
        let (profile, reading) = (cell.profile, cell.reading.map(Into::into));
        Self { profile, reading, large_map, within_2: 0, within_5: 0, beyond: 0, sentences: Vec::new() }
    }
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
        (Profile::Paper2022, _) => "its payoff is that of another paper",
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
