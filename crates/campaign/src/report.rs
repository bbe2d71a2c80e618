//! What a campaign says: cells, tests between planners, and the published tables beside them.

use std::fmt::Write as _;

use contract::{Profile, Weights};
use serde::Serialize;

use crate::markdown::table;
use crate::paper::{self, Published};
use crate::statistics::{Sample, Welch, mean_difference, share_difference, welch};
use crate::tally::Numbers;
use crate::{Cell, Plan, Row, Tally};

/// Folds the rows of a campaign.
#[derive(Clone, Debug)]
pub struct Report {
    plan: Plan,
    tallies: Vec<Tally>,
}

/// A report in numbers, as JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Findings<'a> {
    /// Name of the campaign.
    pub campaign: &'a str,
    /// Its seed.
    pub seed: u64,
    /// Version that flew it.
    pub version: &'a str,
    /// Hash of the plan.
    pub hash: &'a str,
    /// Trials planned.
    pub trials: u64,
    /// Trials flown.
    pub flown: u64,
    /// The cells.
    pub cells: Vec<CellFindings<'a>>,
    /// Welch's tests between planners on the same ground.
    pub planners: Vec<Duel<'a>>,
    /// Sums of the comparison with the paper, by profile; empty unless asked for.
    pub against: Vec<Agreement>,
}

/// One cell in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct CellFindings<'a> {
    /// Scenario.
    pub scenario: &'a str,
    /// Reading of the model.
    pub profile: Profile,
    /// Algorithm.
    pub planner: &'a str,
    /// Weights.
    pub weights: Weights,
    /// Steps after which a mission is a deadlock.
    pub steps_max: u64,
    /// What it came to.
    #[serde(flatten)]
    pub numbers: Numbers,
    /// The paper's cell beside it.
    pub paper: Option<Beside>,
}

/// A published cell beside ours.
#[derive(Clone, Debug, Serialize)]
pub struct Beside {
    /// Number of the paper's table.
    pub table: u32,
    /// Successes of 100.
    pub successes: u64,
    /// Steps over successes.
    pub steps: Sample,
    /// Our share of successes less the paper's, in standard errors under one pooled share.
    pub success_difference_se: Option<f64>,
    /// Our mean steps less the paper's, in standard errors (Welch).
    pub steps_difference_se: Option<f64>,
    /// What is known of a difference.
    pub remark: Option<&'static str>,
}

impl Beside {
    fn new(published: &Published, numbers: &Numbers) -> Self {
        let ours = (numbers.successes, numbers.trials);
        Self {
            table: published.table,
            successes: published.successes,
            steps: published.steps(),
            success_difference_se: share_difference(ours, (published.successes, paper::TRIALS)),
            steps_difference_se: mean_difference(&numbers.steps, &published.steps()),
            remark: published.remark,
        }
    }

    /// The larger of both differences, standard errors.
    #[must_use]
    pub fn difference_se(&self) -> Option<f64> {
        [self.success_difference_se, self.steps_difference_se]
            .into_iter()
            .flatten()
            .map(f64::abs)
            .max_by(f64::total_cmp)
    }
}

/// Two planners on the same ground under the same weights.
#[derive(Clone, Debug, Serialize)]
pub struct Duel<'a> {
    /// Scenario.
    pub scenario: &'a str,
    /// Reading of the model.
    pub profile: Profile,
    /// Weights.
    pub weights: Weights,
    /// One planner.
    pub first: &'a str,
    /// The other.
    pub second: &'a str,
    /// Welch's test of their steps over successes, first less second.
    pub steps: Option<Welch>,
    /// Difference of their shares of successes in standard errors.
    pub success_difference_se: Option<f64>,
    /// Size of the paper's t-value, where it gives one and is asked for.
    pub paper_t: Option<f64>,
}

/// How far a profile's cells are from the paper's, by the larger difference of a cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Reading of the model.
    pub profile: Profile,
    /// Cells within two standard errors.
    pub within_2: usize,
    /// Cells within five, the former not counted again.
    pub within_5: usize,
    /// Cells beyond.
    pub beyond: usize,
    /// A sentence on each cell beyond.
    pub sentences: Vec<String>,
}

impl Report {
    /// The report of `plan` before its first row.
    #[must_use]
    pub fn new(plan: Plan) -> Self {
        let tallies = vec![Tally::default(); plan.cells.len()];
        Self { plan, tallies }
    }

    /// Folds in a row.
    pub fn fold(&mut self, row: &Row) {
        if let Some(tally) = usize::try_from(row.cell).ok().and_then(|cell| self.tallies.get_mut(cell)) {
            tally.fold(row);
        }
    }

    /// The numbers, beside the paper's if `against_paper`.
    #[must_use]
    pub fn findings(&self, against_paper: bool) -> Findings<'_> {
        let cells: Vec<_> =
            self.cells().map(|(cell, tally)| cell_findings(cell, tally, against_paper)).collect();
        Findings {
            campaign: &self.plan.name,
            seed: self.plan.seed,
            version: &self.plan.version,
            hash: &self.plan.hash,
            trials: self.plan.trials(),
            flown: self.tallies.iter().map(Tally::trials).sum(),
            planners: duels(&cells, against_paper),
            against: if against_paper { agreements(&cells) } else { Vec::new() },
            cells,
        }
    }

    /// Cells with their tallies.
    pub fn cells(&self) -> impl Iterator<Item = (&Cell, &Tally)> {
        self.plan.cells.iter().zip(&self.tallies)
    }
}

fn cell_findings<'a>(cell: &'a Cell, tally: &Tally, against_paper: bool) -> CellFindings<'a> {
    let numbers = tally.numbers(cell.steps_max);
    let published = paper::published(&cell.scenario, &cell.planner, &cell.weights).filter(|_| against_paper);
    CellFindings {
        scenario: &cell.scenario,
        profile: cell.profile,
        planner: &cell.planner,
        weights: cell.weights,
        steps_max: cell.steps_max,
        paper: published.map(|published| Beside::new(&published, &numbers)),
        numbers,
    }
}

fn duels<'a>(cells: &[CellFindings<'a>], against_paper: bool) -> Vec<Duel<'a>> {
    let mut duels = Vec::new();
    for (place, first) in cells.iter().enumerate() {
        let same_ground = |second: &&CellFindings<'_>| {
            (first.scenario, first.profile, first.weights)
                == (second.scenario, second.profile, second.weights)
        };
        for second in cells[place + 1..].iter().filter(same_ground) {
            let papers = [first.planner, second.planner] == ["mdp", "greedy"]
                && first.paper.is_some()
                && first.profile == Profile::Paper2023;
            duels.push(Duel {
                scenario: first.scenario,
                profile: first.profile,
                weights: first.weights,
                first: first.planner,
                second: second.planner,
                steps: welch(&first.numbers.steps, &second.numbers.steps),
                success_difference_se: share_difference(
                    (first.numbers.successes, first.numbers.trials),
                    (second.numbers.successes, second.numbers.trials),
                ),
                paper_t: paper::t_value(first.scenario, &first.weights).filter(|_| papers && against_paper),
            });
        }
    }
    duels
}

fn agreements(cells: &[CellFindings<'_>]) -> Vec<Agreement> {
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

/// Which cell is beyond, by how much, and what is known of it.
fn sentence(cell: &CellFindings<'_>, beside: &Beside) -> String {
    let mut parts = Vec::new();
    let numbers = &cell.numbers;
    if let Some(difference) = beside.success_difference_se.filter(|difference| difference.abs() > 5.0) {
        parts.push(format!(
            "succeeds in {} where the paper has {} % ({difference:+.1} standard errors)",
            percent(numbers.successes, numbers.trials),
            beside.successes
        ));
    }
    if let Some(difference) = beside.steps_difference_se.filter(|difference| difference.abs() > 5.0) {
        parts.push(format!(
            "needs {} steps where the paper has {} ({difference:+.1} standard errors)",
            spread(&numbers.steps),
            spread(&beside.steps)
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
        pair(&cell.weights),
        parts.join(" and ")
    )
}

impl Findings<'_> {
    /// The report as Markdown.
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
                 restricted mean each failure counts as the step limit.\n\n";
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
        text
    }

    fn cell_table(&self) -> String {
        let rows = self.cells.iter().map(|cell| {
            let Numbers { trials, successes, success_interval, failures, steps, .. } = &cell.numbers;
            let failures: Vec<_> = failures.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
            [
                cell.scenario.into(),
                cell.profile.to_string(),
                cell.planner.into(),
                pair(&cell.weights),
                format!("{successes} of {trials}, {}", percent(*successes, *trials)),
                format!("{:.1} to {:.1} %", 100.0 * success_interval.low, 100.0 * success_interval.high),
                if failures.is_empty() { "none".into() } else { failures.join(", ") },
                spread(steps),
                number(cell.numbers.restricted_mean_steps, 1),
                cell.numbers.mean_coverage.map_or("-".into(), |share| format!("{:.0} %", 100.0 * share)),
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
            "seen",
        ];
        table(headings, &rows.collect::<Vec<_>>())
    }

    fn planner_table(&self) -> String {
        let rows = self.planners.iter().map(|duel| {
            let welch = duel.steps.as_ref();
            [
                duel.scenario.into(),
                duel.profile.to_string(),
                pair(&duel.weights),
                format!("{} - {}", duel.first, duel.second),
                signed(welch.map(|welch| welch.t)),
                number(welch.map(|welch| welch.degrees), 1),
                number(welch.map(|welch| welch.critical), 2),
                welch.map_or("-".into(), |welch| format!("{:.2e}", welch.p)),
                signed(duel.success_difference_se),
                number(duel.paper_t, 2),
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
            "paper's t",
        ];
        table(headings, &rows.collect::<Vec<_>>())
    }

    fn paper_table(&self) -> String {
        let rows = self.cells.iter().filter_map(|cell| {
            let beside = cell.paper.as_ref()?;
            let numbers = &cell.numbers;
            Some([
                beside.table.to_string(),
                cell.scenario.into(),
                cell.profile.to_string(),
                cell.planner.into(),
                pair(&cell.weights),
                percent(numbers.successes, numbers.trials),
                format!("{} %", beside.successes),
                signed(beside.success_difference_se),
                spread(&numbers.steps),
                spread(&beside.steps),
                signed(beside.steps_difference_se),
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
        ];
        table(headings, &rows.collect::<Vec<_>>())
    }

    fn agreement_text(&self) -> String {
        let mut text = String::new();
        for Agreement { profile, within_2, within_5, beyond, sentences } in &self.against {
            let cells = within_2 + within_5 + beyond;
            let _ = writeln!(
                text,
                "Profile {profile}: of {cells} cells {within_2} are within 2 standard errors of the paper in both \
                 success and steps, {within_5} more within 5, {beyond} beyond.\n"
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
            "mean_hops",
            "mean_coverage",
            "paper_table",
            "paper_successes",
            "paper_steps_mean",
            "paper_steps_sd",
            "success_difference_se",
            "steps_difference_se",
        ];
        let exact = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let mut records = vec![headings.map(String::from).to_vec()];
        for cell in &self.cells {
            let numbers = &cell.numbers;
            let paper = cell.paper.as_ref();
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
                exact(numbers.restricted_mean_steps),
                exact(numbers.mean_hops),
                exact(numbers.mean_coverage),
                paper.map_or(String::new(), |paper| paper.table.to_string()),
                paper.map_or(String::new(), |paper| paper.successes.to_string()),
                exact(paper.and_then(|paper| paper.steps.mean)),
                exact(paper.and_then(|paper| paper.steps.sd)),
                exact(paper.and_then(|paper| paper.success_difference_se)),
                exact(paper.and_then(|paper| paper.steps_difference_se)),
            ]);
        }
        records
    }
}

fn pair(weights: &Weights) -> String {
    let Weights { safety, information, distance } = weights;
    if *distance == 10.0 {
        format!("({safety}, {information})")
    } else {
        format!("({safety}, {information}, {distance})")
    }
}

fn percent(part: u64, whole: u64) -> String {
    if whole == 0 { "-".into() } else { format!("{:.1} %", 100.0 * part as f64 / whole as f64) }
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.digits$}"))
}

fn signed(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:+.1}"))
}

fn spread(sample: &Sample) -> String {
    match (sample.mean, sample.sd) {
        (Some(mean), Some(sd)) => format!("{mean:.1} ± {sd:.1}"),
        (Some(mean), None) => format!("{mean:.1}"),
        _ => "-".into(),
    }
}
