//! The report of a campaign beside the paper as CSV records.

use crate::paper_report::PaperReport;

/// Headings of the columns that the paper adds.
const HEADINGS: [&str; 8] = [
    "paper_table",
    "paper_successes",
    "paper_steps_mean",
    "paper_steps_sd",
    "success_difference_se",
    "steps_difference_se",
    "paper_mean_treasures",
    "treasures_difference_se",
];

impl PaperReport<'_> {
    /// CSV records: the headings, then one record for each cell.
    #[must_use]
    pub fn records(&self) -> Vec<Vec<String>> {
        let exact = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let values = self.cells.iter().map(|cell| {
            let paper = cell.paper.as_ref();
            [
                paper.map_or(String::new(), |paper| paper.table.to_string()),
                paper.map_or(String::new(), |paper| paper.successes.to_string()),
                exact(paper.and_then(|paper| paper.steps.mean)),
                exact(paper.and_then(|paper| paper.steps.sd)),
                exact(paper.and_then(|paper| paper.success_difference_se)),
                exact(paper.and_then(|paper| paper.steps_difference_se)),
                exact(paper.and_then(|paper| paper.treasures?.mean)),
                exact(paper.and_then(|paper| paper.treasures_difference_se)),
            ]
        });
        let added = std::iter::once(HEADINGS.map(String::from)).chain(values);
        let beside = |(record, added): (Vec<String>, [String; 8])| record.into_iter().chain(added).collect();
        self.results.records().into_iter().zip(added).map(beside).collect()
    }
}
