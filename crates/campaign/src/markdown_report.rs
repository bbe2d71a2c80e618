//! The report of a campaign as Markdown.

use std::fmt::Write as _;

use crate::agreement::Agreement;
use crate::cell_results::Regret;
use crate::markdown::table;
use crate::notation::{number, percent, signed, spread, treasures_collected, weights_in_brackets};
use crate::report::CampaignResults;
use crate::tally::CellStatistics;

impl CampaignResults<'_> {
    /// The report as a page of Markdown: cells, planners, and, where asked for, the paper.
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
        if !self.against.is_empty() {
            text += "## Against the paper\n\nOurs beside Sakamoto & Kunii 2023; differences, ours less theirs, \
                     in standard errors.\n\n";
            text += &self.paper_table();
            text += &self.agreement_text();
        }
        if !self.tests.is_empty() {
            text += "## The paper's t-tests\n\nMDP against greedy: sizes of t. \"From its tables\" is Student's t with \
                     pooled variance from the paper's own counts, means and deviations; ours is Welch's.\n\n";
            text += &self.test_table();
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

    fn paper_table(&self) -> String {
        let rows = self.cells.iter().filter_map(|cell| {
            let beside = cell.paper.as_ref()?;
            let statistics = &cell.statistics;
            Some([
                beside.table.to_string(),
                cell.scenario.into(),
                cell.profile.to_string(),
                cell.planner.into(),
                weights_in_brackets(&cell.weights),
                percent(statistics.successes, statistics.trials),
                format!("{} %", beside.successes),
                signed(beside.success_difference_se),
                spread(&statistics.steps),
                spread(&beside.steps),
                signed(beside.steps_difference_se),
                treasures_of(statistics),
                treasures_collected(beside.treasure_counts.iter().rev().copied()),
                signed(beside.treasures_difference_se),
            ])
        });
        let headings = [
            "table",
            "scenario",
            "profile",
            "planner",
            "w1, w2",
            "success",
            "paper",
            "difference",
            "steps",
            "paper",
            "difference",
            "treasures",
            "paper",
            "difference",
        ];
        table(headings, &rows.collect::<Vec<_>>())
    }

    fn agreement_text(&self) -> String {
        let mut text = String::new();
        for agreement in &self.against {
            let Agreement { profile, reading, large_map, within_2, within_5, beyond, sentences } = agreement;
            let cells = within_2 + within_5 + beyond;
            let reading = reading.as_ref().map_or(String::new(), |reading| format!(", {reading}"));
            let which =
                if *large_map { "cells of the large map, which is not the paper's," } else { "cells" };
            let _ = writeln!(
                text,
                "Profile {profile}{reading}: of {cells} {which} {within_2} are within 2 standard errors of the paper in success, \
                 steps and treasures, {within_5} more within 5, {beyond} beyond.\n"
            );
            for sentence in sentences {
                let _ = writeln!(text, "- {sentence}");
            }
            if !sentences.is_empty() {
                text.push('\n');
            }
        }
        text
    }

    fn test_table(&self) -> String {
        let rows = self.tests.iter().map(|test| {
            let [safety, information] = test.weights;
            [
                test.table.to_string(),
                test.scenario.into(),
                format!("({safety}, {information})"),
                test.of.into(),
                number(test.paper_t, 3),
                format!("{:.2}", test.paper_critical),
                number(test.paper_recomputed_t, 2),
                number(test.ours.as_ref().map(|welch| welch.t.abs()), 2),
                number(test.ours.as_ref().map(|welch| welch.critical), 2),
                test.oddity().unwrap_or_default().into(),
            ]
        });
        let headings = [
            "table",
            "scenario",
            "w1, w2",
            "of",
            "paper's t",
            "critical",
            "from its tables",
            "ours",
            "critical",
            "odd about the paper's",
        ];
        table(headings, &rows.collect::<Vec<_>>())
    }
}

fn treasures_of(statistics: &CellStatistics) -> String {
    if statistics.treasure_counts.keys().all(|number| *number == 0) {
        return "-".into();
    }
    treasures_collected(statistics.treasure_counts.iter().map(|(number, episodes)| (*number, *episodes)))
}

fn regret(regret: &Regret) -> String {
    format!(
        "{} points, {} steps",
        number(regret.success.map(|share| 100.0 * share), 1),
        number(regret.restricted_mean_steps, 1)
    )
}
