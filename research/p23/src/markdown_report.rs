//! The report of a campaign beside the paper as Markdown.

use std::fmt::Write as _;

use campaign::markdown::table;
use campaign::notation::{
    number, percent, signed, spread, treasures_collected, treasures_of, weights_in_brackets,
};

use crate::agreement::Agreement;
use crate::cell_beside_paper::CellBesidePaper;
use crate::claim::Claim;
use crate::paper_report::PaperReport;

/// With its sign, two decimals.
fn signed_number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:+.2}"))
}

impl PaperReport<'_> {
    /// The report as a page of Markdown: cells, planners, and, where asked for, the paper.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = self.results.markdown();
        if !self.against.is_empty() {
            text += "## Against the paper\n\nOurs beside Sakamoto & Kunii 2023; differences, ours less theirs, \
                     in standard errors.\n\n";
            text += &self.paper_table();
            text += &self.agreement_text();
        }
        if !self.tests.is_empty() {
            text += "## The paper's t-tests\n\nMDP against greedy: t, above 0 where the MDP has more; the paper prints no \
                     signs. \"From its tables\" is Student's t with pooled variance from the paper's own counts, means \
                     and deviations; ours is Welch's.\n\n";
            text += &self.test_table();
        }
        if !self.claims.is_empty() {
            text += "## The paper's claims\n\nThose of profile paper-2023; a verdict needs the whole 95 % interval on one side.\n\n";
            text += &self.claim_table();
        }
        text
    }

    fn paper_table(&self) -> String {
        let rows = self.cells.iter().filter_map(|CellBesidePaper { results: cell, paper }| {
            let beside = paper.as_ref()?;
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

    fn claim_table(&self) -> String {
        table(Claim::HEADINGS, &self.claims.iter().map(Claim::cells).collect::<Vec<_>>())
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
                signed_number(test.paper_recomputed_t),
                signed_number(test.ours.as_ref().map(|welch| welch.t)),
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
