//! The cells as records for CSV.

use crate::report::Findings;

impl Findings<'_> {
    /// The cells as records for CSV: headings, then one a cell.
    #[must_use]
    pub fn records(&self) -> Vec<Vec<String>> {
        let headings = [
            "scenario",
            "profile",
            "planner",
            "w1",
            "w2",
            "w3",
            "trials",
            "successes",
            "success_low",
            "success_high",
            "deadlock",
            "left_map",
            "lost",
            "stopped",
            "steps_mean",
            "steps_sd",
            "restricted_mean_steps",
            "restricted_sd_steps",
            "mean_treasures",
            "mean_hops",
            "mean_coverage",
            "bound_success",
            "bound_restricted_mean_steps",
            "regret_success",
            "regret_restricted_mean_steps",
            "paper_table",
            "paper_successes",
            "paper_steps_mean",
            "paper_steps_sd",
            "success_difference_se",
            "steps_difference_se",
            "paper_mean_treasures",
            "treasures_difference_se",
        ];
        let exact = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let mut records = vec![headings.map(String::from).to_vec()];
        for cell in &self.cells {
            let numbers = &cell.numbers;
            let (paper, regret) = (cell.paper.as_ref(), cell.regret.as_ref());
            let kind = |kind: &str| numbers.failures.get(kind).copied().unwrap_or(0).to_string();
            records.push(vec![
                cell.scenario.into(),
                cell.profile.to_string(),
                cell.planner.into(),
                cell.weights.safety.to_string(),
                cell.weights.information.to_string(),
                cell.weights.distance.to_string(),
                numbers.trials.to_string(),
                numbers.successes.to_string(),
                numbers.success_interval.low.to_string(),
                numbers.success_interval.high.to_string(),
                kind("deadlock"),
                kind("left_map"),
                kind("lost"),
                kind("stopped"),
                exact(numbers.steps.mean),
                exact(numbers.steps.sd),
                exact(numbers.restricted_steps.mean),
                exact(numbers.restricted_steps.sd),
                exact(numbers.treasures.mean),
                exact(numbers.mean_hops),
                exact(numbers.mean_coverage),
                exact(regret.map(|regret| regret.bound.success)),
                exact(regret.map(|regret| regret.bound.restricted_mean_steps)),
                exact(regret.and_then(|regret| regret.success)),
                exact(regret.and_then(|regret| regret.restricted_mean_steps)),
                paper.map_or(String::new(), |paper| paper.table.to_string()),
                paper.map_or(String::new(), |paper| paper.successes.to_string()),
                exact(paper.and_then(|paper| paper.steps.mean)),
                exact(paper.and_then(|paper| paper.steps.sd)),
                exact(paper.and_then(|paper| paper.success_difference_se)),
                exact(paper.and_then(|paper| paper.steps_difference_se)),
                exact(paper.and_then(|paper| paper.treasures?.mean)),
                exact(paper.and_then(|paper| paper.treasures_difference_se)),
            ]);
        }
        records
    }
}
