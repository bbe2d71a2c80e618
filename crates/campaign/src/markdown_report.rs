//! The report of a campaign as Markdown.

use crate::cell_results::Regret;
use crate::markdown::table;
use crate::notation::{number, percent, signed, spread, treasures_of, weights_in_brackets};
use crate::report::CampaignResults;
use crate::tally::CellStatistics;

impl CampaignResults<'_> {
    /// The report as a page of Markdown: cells and planners.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "# Campaign {}\n\n{} of {} trials, seed {}, version {}, plan {}.\n\n",
            self.campaign,
            self.flown,
            self.trials,
            self.seed,
            self.version,
            &self.hash[..16.min(self.hash.len())]
        );
        text += "## Cells\n\nSuccesses with Wilson's 95 % interval; steps are mean ± sd over successes; in the \
                 restricted mean each failure counts as the step limit. Treasures: number collected (successes that \
                 did). Regret: points of success and restricted steps short of the clairvoyant's bounds.\n\n";
        text += &self.cell_table();
        if !self.planners.is_empty() {
            text += "## Planners\n\nWelch's t-test of the steps over successes, first planner less second; \
                     success in standard errors of the difference.\n\n";
            text += &self.planner_table();
        }
        text
    }

    fn cell_table(&self) -> String {
        let rows = self.cells.iter().map(|cell| {
            let CellStatistics { trials, successes, success_interval, failures, steps, .. } =
                &cell.statistics;
            let failures: Vec<_> = failures.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
            [
                cell.scenario.into(),
                cell.reading.map_or_else(|| cell.profile.to_string(), Into::into),
                cell.planner.into(),
                weights_in_brackets(&cell.weights),
                format!("{successes} of {trials}, {}", percent(*successes, *trials)),
                format!("{:.1} to {:.1} %", 100.0 * success_interval.low, 100.0 * success_interval.high),
                if failures.is_empty() { "none".into() } else { failures.join(", ") },
                spread(steps),
                number(cell.statistics.restricted_steps.mean, 1),
                treasures_of(&cell.statistics),
                cell.statistics.mean_coverage.map_or("-".into(), |share| format!("{:.0} %", 100.0 * share)),
                cell.regret.as_ref().map_or("-".into(), regret),
            ]
        });
        let headings = [
            "scenario",
            "profile",
            "planner",
            "w1, w2",
            "successes",
            "95 %",
            "failures",
            "steps",
            "restricted mean",
            "treasures",
            "seen",
            "regret",
        ];
        table(headings, &rows.collect::<Vec<_>>())
    }

    fn planner_table(&self) -> String {
        let rows = self.planners.iter().map(|comparison| {
            let welch = comparison.steps.as_ref();
            [
                comparison.scenario.into(),
                comparison.profile.to_string(),
                weights_in_brackets(&comparison.weights),
                format!("{} - {}", comparison.first, comparison.second),
                signed(welch.map(|welch| welch.t)),
                number(welch.map(|welch| welch.degrees), 1),
                number(welch.map(|welch| welch.critical), 2),
                welch.map_or("-".into(), |welch| format!("{:.2e}", welch.p)),
                signed(comparison.success_difference_se),
                signed(comparison.treasures.as_ref().map(|welch| welch.t)),
            ]
        });
        let headings = [
            "scenario",
            "profile",
            "w1, w2",
            "planners",
            "t",
            "degrees",
            "critical 5 %",
            "p",
            "success",
            "treasures, t",
        ];
        table(headings, &rows.collect::<Vec<_>>())
    }
}

fn regret(regret: &Regret) -> String {
    format!(
        "{} points, {} steps",
        number(regret.success.map(|share| 100.0 * share), 1),
        number(regret.restricted_mean_steps, 1)
    )
}
