//! Compares two campaigns on the same cells, with a verdict on each cell of the MDP.
//!
//! A cell is accepted if, each at 95 % and one-sided,
//!
//! 1. its success is not significantly below the paper's count of 100 (Fisher's exact test),
//! 2. nor below the other campaign's (the same),
//! 3. its restricted mean is not significantly above the other's (Welch's test; whether it is below as it
//!    stands is reported as well). Treasures cost detours: where it collects significantly more than the other's, the
//!    paper's mean steps take the place of the other's restricted mean,
//! 4. its successes collect, where the paper counts treasures, not significantly fewer than the paper's (Welch's test),
//! 5. and on the paper's sandy ground, its success lies within [`REGRET_MAX`] of the clairvoyant's bound.
//!
//! With fifteen cells and three or four tests each, two or three rejections by chance are expected even of planners
//! that are equal.

use std::fmt::Write as _;

use campaign::cell_results::CellResults;
use campaign::markdown::table;
use campaign::notation::{number, percent, signed, spread, weights_in_brackets};
use campaign::report::CampaignResults;
use campaign::statistics::{fisher_below, mean_difference, welch_above};
use contract::Weights;
use serde::Serialize;

use crate::cell_beside_paper::CellBesidePaper;
use crate::tables::{self, Published};

/// Probability below which a difference counts as significant, one-sided.
const SIGNIFICANCE: f64 = 0.05;

/// Largest accepted gap between success on sandy ground and the clairvoyant's bound, as a share.
pub const REGRET_MAX: f64 = 0.01;

/// Two campaigns, cell by cell.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison<'a> {
    /// Name of the campaign that is judged.
    pub campaign: &'a str,
    /// Name of the campaign it is compared with.
    pub beside: &'a str,
    /// The cells that both campaigns have.
    pub cells: Vec<Pair<'a>>,
}

/// The cells of both campaigns with the same scenario, planner and weights.
#[derive(Clone, Debug, Serialize)]
pub struct Pair<'a> {
    /// The cell that is judged.
    pub ours: CellBesidePaper<'a>,
    /// The cell it is compared with.
    pub other: CellBesidePaper<'a>,
    /// What the tests say; `None` for planners other than the MDP.
    pub verdict: Option<Verdict>,
    #[serde(skip)]
    published: Option<Published>,
}

/// Results of the tests on one cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Probability of so few successes if the paper's planner were no better.
    pub success_p_paper: Option<f64>,
    /// Probability of so few successes if the other's were no better.
    pub success_p_other: Option<f64>,
    /// Restricted mean less the other's, in standard errors.
    pub restricted_difference_se: Option<f64>,
    /// Probability of so large a restricted mean if the other's were no smaller.
    pub restricted_p_other: Option<f64>,
    /// Probability of so large a restricted mean if the paper's steps were no fewer; only where the cell collects
    /// significantly more treasures than the other's.
    pub steps_p_paper: Option<f64>,
    /// Probability of so few treasures if the paper's planner collected no more; `None` where it counts none.
    pub treasures_p_paper: Option<f64>,
    /// Whether the restricted mean is below the other's as it stands.
    pub restricted_below: bool,
    /// The criteria that are missed; empty if the cell is accepted.
    pub missed: Vec<&'static str>,
}

impl Verdict {
    fn new(ours: &CellResults<'_>, other: &CellResults<'_>, published: Option<&Published>) -> Self {
        let share = |cell: &CellResults<'_>| (cell.statistics.successes, cell.statistics.trials);
        let (restricted, others) = (&ours.statistics.restricted_steps, &other.statistics.restricted_steps);
        let success_p_paper =
            published.and_then(|paper| fisher_below(share(ours), (paper.successes, tables::TRIALS)));
        let success_p_other = fisher_below(share(ours), share(other));
        let restricted_p_other = welch_above(restricted, others);
        // Fewer of ours is more of theirs.
        let treasures_p_paper = published
            .and_then(Published::treasures)
            .and_then(|theirs| welch_above(&theirs, &ours.statistics.treasures));
        let significant = |p: Option<f64>| p.is_some_and(|p| p < SIGNIFICANCE);
        // More treasures may take more steps than the other's fewer, but no more than the paper's.
        let collects_more = significant(welch_above(&ours.statistics.treasures, &other.statistics.treasures));
        let steps_p_paper = match published {
            Some(published) if collects_more && published.treasures().is_some() => {
                welch_above(restricted, &published.steps())
            }
            _ => None,
        };
        let is_slower = significant(restricted_p_other) && steps_p_paper.is_none();
        let regret = match ours.regret {
            Some(regret) if ours.scenario == "sandy" => regret.success,
            _ => None,
        };
        let misses = [
            (significant(success_p_paper), "success below the paper's"),
            (significant(success_p_other), "success below the other's"),
            (is_slower, "restricted mean above the other's"),
            (significant(steps_p_paper), "restricted mean above the paper's steps"),
            (significant(treasures_p_paper), "fewer treasures than the paper's"),
            (regret.is_some_and(|regret| regret > REGRET_MAX), "success short of the bound"),
        ];
        Self {
            success_p_paper,
            success_p_other,
            restricted_difference_se: mean_difference(restricted, others),
            restricted_p_other,
            steps_p_paper,
            treasures_p_paper,
            restricted_below: restricted.mean < others.mean,
            missed: misses.into_iter().filter_map(|(missed, what)| missed.then_some(what)).collect(),
        }
    }

    /// Whether no criterion is missed.
    #[must_use]
    pub fn accepted(&self) -> bool {
        self.missed.is_empty()
    }
}

impl<'a> Comparison<'a> {
    /// Compares `ours` with `other` over the cells of `ours` that `other` has too, whatever their profiles.
    #[must_use]
    pub fn new(ours: &'a CampaignResults<'a>, other: &'a CampaignResults<'a>) -> Self {
        let key = |cell: &CellResults<'a>| (cell.scenario, cell.planner, cell.weights);
        let pairs = ours.cells.iter().filter_map(|cell| {
            let beside = other.cells.iter().find(|beside| key(beside) == key(cell))?;
            let published = tables::published(cell.scenario, cell.planner, &cell.weights);
            let verdict = (cell.planner == "mdp").then(|| Verdict::new(cell, beside, published.as_ref()));
            let [ours, other] = [cell, beside].map(|results| CellBesidePaper { results, paper: None });
            Some(Pair { ours, other, verdict, published })
        });
        let cells = pairs.collect();
        Self { campaign: ours.campaign, beside: other.campaign, cells }
    }

    /// Whether every judged cell is accepted.
    #[must_use]
    pub fn accepted(&self) -> bool {
        self.verdicts().all(Verdict::accepted)
    }

    fn verdicts(&self) -> impl Iterator<Item = &Verdict> {
        self.cells.iter().filter_map(|pair| pair.verdict.as_ref())
    }

    /// The comparison as Markdown: a table of all cells, then the verdicts.
    #[must_use]
    pub fn markdown(&self) -> String {
        self.cell_table() + &self.verdict_table() + &self.summary()
    }

    fn cell_table(&self) -> String {
        let column = |cell: &CellResults<'_>| {
            let statistics = &cell.statistics;
            let success = percent(statistics.successes, statistics.trials);
            [format!("{success}, {}", spread(&statistics.steps)), number(statistics.restricted_steps.mean, 1)]
        };
        let rows = self.cells.iter().map(|Pair { ours, other, published, .. }| {
            let paper = published.map_or("-".into(), |paper| {
                format!("{} %, {}", paper.successes, number(paper.steps().mean, 1))
            });
            let ours = ours.results;
            let [theirs, their_mean] = column(other.results);
            let [own, own_mean] = column(ours);
            let bound = ours.regret.as_ref().map_or("-".into(), |regret| {
                let bound = regret.bound;
                format!("{:.1} %, {:.1}", 100.0 * bound.success, bound.restricted_mean_steps)
            });
            let weights = bare(&ours.weights);
            [
                ours.scenario.into(),
                ours.planner.into(),
                weights,
                paper,
                theirs,
                their_mean,
                own,
                own_mean,
                bound,
            ]
        });
        let (other, ours) = (format!("`{}`", self.beside), format!("`{}`", self.campaign));
        let headings =
            ["ground", "planner", "w1, w2", "paper", &other, "restricted", &ours, "restricted", "bounds"];
        table(headings, &rows.collect::<Vec<_>>())
    }

    fn verdict_table(&self) -> String {
        let p = |p: Option<f64>| p.map_or("-".into(), |p| format!("{p:.3}"));
        let rows = self.cells.iter().filter_map(|Pair { ours, verdict, .. }| {
            let (ours, verdict) = (ours.results, verdict.as_ref()?);
            Some([
                ours.scenario.into(),
                bare(&ours.weights),
                p(verdict.success_p_paper),
                p(verdict.success_p_other),
                p(verdict.treasures_p_paper),
                signed(verdict.restricted_difference_se),
                if verdict.restricted_below { "yes".into() } else { "no".into() },
                if verdict.accepted() { "accepted".into() } else { verdict.missed.join(", ") },
            ])
        });
        let headings = [
            "ground",
            "w1, w2",
            "p, success below the paper's",
            "p, success below the other's",
            "p, fewer treasures than the paper's",
            "restricted mean, se",
            "below as it stands",
            "verdict",
        ];
        let rows: Vec<_> = rows.collect();
        if rows.is_empty() { String::new() } else { table(headings, &rows) }
    }

    fn summary(&self) -> String {
        let (judged, accepted, below) =
            self.verdicts().fold((0, 0, 0), |(judged, accepted, below), verdict| {
                let count = |is: bool| usize::from(is);
                (judged + 1, accepted + count(verdict.accepted()), below + count(verdict.restricted_below))
            });
        let mut text = String::new();
        if judged > 0 {
            let _ = writeln!(
                text,
                "{accepted} of {judged} cells of the MDP are accepted: success not significantly below the paper's or the \
                 other's, treasures not significantly fewer than the paper's where it counts them, restricted mean not \
                 significantly above (or, with more treasures than the other's, not above the paper's steps; one-sided, \
                 95 %), and on sandy ground within {:.0} point of the clairvoyant's \
                 success. In {below} the restricted mean is below the other's as it stands.",
                100.0 * REGRET_MAX
            );
        }
        text
    }
}

/// Weights without brackets, for tables.
fn bare(weights: &Weights) -> String {
    weights_in_brackets(weights).trim_matches(['(', ')']).into()
}

#[cfg(test)]
mod tests {
    use campaign::statistics::Sample;
    use campaign::tally::{CellStatistics, Tally};
    use contract::{MotionModel, Profile};

    use super::*;

    fn sample(mean: f64, sd: f64) -> Sample {
        Sample { count: 1000, mean: Some(mean), sd: Some(sd) }
    }

    /// A cell of the treasure hunt at (0, 1) with these mean steps and treasures, all missions at the goal.
    fn cell(steps: f64, treasures: f64) -> CellResults<'static> {
        let statistics = Tally::default().statistics(150);
        CellResults {
            scenario: "treasures",
            profile: Profile::Hopper,
            planner: "mdp",
            weights: Weights { safety: 0.0, information: 1.0, distance: 10.0 },
            reading: None,
            dynamics: MotionModel::Law,
            steps_max: 150,
            statistics: CellStatistics {
                trials: 1000,
                successes: 1000,
                steps: sample(steps, 8.0),
                restricted_steps: sample(steps, 8.0),
                treasures: sample(treasures, 0.3),
                ..statistics
            },
            regret: None,
        }
    }

    #[test]
    fn more_treasures_excuse_more_steps_up_to_the_papers() {
        let other = cell(75.4, 1.99);
        let published = tables::published("treasures", "mdp", &other.weights).expect("a cell of Table 15");
        let missed =
            |steps, treasures| Verdict::new(&cell(steps, treasures), &other, Some(&published)).missed;
        assert!(missed(75.4, 2.07).is_empty());
        assert!(missed(77.7, 2.07).is_empty(), "the paper has 78.0 steps");
        assert_eq!(missed(80.0, 2.07), ["restricted mean above the paper's steps"]);
        assert_eq!(missed(77.7, 2.0), ["restricted mean above the other's"], "no more treasures");
        assert_eq!(missed(75.4, 1.9), ["fewer treasures than the paper's"]);
    }
}
