//! The results of a campaign as CSV records.

use crate::report::CampaignResults;

impl CampaignResults<'_> {
    /// CSV records: the headings, then one record for each cell.
    // Long: every column is listed twice, by name and by value.
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
        ];
        let exact = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let mut records = vec![headings.map(String::from).to_vec()];
        for cell in &self.cells {
            let statistics = &cell.statistics;
            let regret = cell.regret.as_ref();
            let kind = |kind: &str| statistics.failures.get(kind).copied().unwrap_or(0).to_string();
            records.push(vec![
                cell.scenario.into(),
                cell.profile.to_string(),
                cell.planner.into(),
                cell.weights.safety.to_string(),
                cell.weights.information.to_string(),
                cell.weights.distance.to_string(),
                statistics.trials.to_string(),
                statistics.successes.to_string(),
                statistics.success_interval.low.to_string(),
                statistics.success_interval.high.to_string(),
                kind("deadlock"),
                kind("left_map"),
                kind("lost"),
                kind("stopped"),
                exact(statistics.steps.mean),
                exact(statistics.steps.sd),
                exact(statistics.restricted_steps.mean),
                exact(statistics.restricted_steps.sd),
                exact(statistics.treasures.mean),
                exact(statistics.mean_hops),
                exact(statistics.mean_coverage),
                exact(regret.map(|regret| regret.bound.success)),
                exact(regret.map(|regret| regret.bound.restricted_mean_steps)),
                exact(regret.and_then(|regret| regret.success)),
                exact(regret.and_then(|regret| regret.restricted_mean_steps)),
            ]);
        }
        records
    }
}
