//! The published tables beside a campaign's cells.

use contract::Profile;
use serde::Serialize;

use crate::number::{number, pair, percent, spread};
use crate::paper::{self, Published, PublishedTest};
use crate::report::CellFindings;
use crate::statistics::{Sample, Welch, mean_difference, share_difference, welch};
use crate::tally::Numbers;

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
    /// Treasures collected by successes, where the paper counts them.
    pub treasures: Option<Sample>,
    /// How many successes collected how many.
    #[serde(skip)]
    pub treasure_counts: &'static [(u64, u64)],
    /// Our mean treasures less the paper's, in standard errors (Welch).
    pub treasures_difference_se: Option<f64>,
    /// What is known of a difference.
    pub remark: Option<&'static str>,
}

impl Beside {
    pub(crate) fn new(published: &Published, numbers: &Numbers) -> Self {
        let ours = (numbers.successes, numbers.trials);
        Self {
            table: published.table,
            successes: published.successes,
            steps: published.steps(),
            success_difference_se: share_difference(ours, (published.successes, paper::TRIALS)),
            steps_difference_se: mean_difference(&numbers.steps, &published.steps()),
            treasures: published.treasures(),
            treasure_counts: published.treasures,
            treasures_difference_se: published
                .treasures()
                .and_then(|treasures| mean_difference(&numbers.treasures, &treasures)),
            remark: published.remark,
        }
    }

    /// The largest of the differences, standard errors.
    #[must_use]
    pub fn difference_se(&self) -> Option<f64> {
        [self.success_difference_se, self.steps_difference_se, self.treasures_difference_se]
            .into_iter()
            .flatten()
            .map(f64::abs)
            .max_by(f64::total_cmp)
    }
}

/// How far a profile's cells are from the paper's, by the largest difference of a cell.
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

pub(crate) fn agreements(cells: &[CellFindings<'_>]) -> Vec<Agreement> {
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
    let treasures = beside.treasures_difference_se.filter(|difference| difference.abs() > 5.0);
    if let (Some(difference), Some(papers)) = (treasures, &beside.treasures) {
        parts.push(format!(
            "collects {} treasures where the paper has {} ({difference:+.1} standard errors)",
            number(numbers.treasures.mean, 2),
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
        pair(&cell.weights),
        parts.join(" and ")
    )
}

/// One of the paper's t-tests of greedy against MDP beside ours. Sizes; the paper prints no signs.
#[derive(Clone, Debug, Serialize)]
pub struct TestBeside {
    /// Number of the paper's table.
    pub table: u32,
    /// Scenario.
    pub scenario: &'static str,
    /// w1 and w2.
    pub weights: [f64; 2],
    /// What is tested: steps or treasures.
    pub of: &'static str,
    /// The paper's t-value, unless a dash is printed.
    pub paper_t: Option<f64>,
    /// Its critical value.
    pub paper_critical: f64,
    /// Whether its text claims that the null hypothesis is rejected.
    pub paper_claims_rejection: bool,
    /// Student's t from the paper's own counts, means and deviations.
    pub paper_recomputed_t: Option<f64>,
    /// Our Welch's test.
    pub ours: Option<Welch>,
}

impl TestBeside {
    fn new(published: &PublishedTest, cells: &[CellFindings<'_>]) -> Option<Self> {
        let [safety, information] = published.weights;
        let find = |planner| {
            cells.iter().find(|cell| {
                cell.paper.is_some()
                    && cell.profile == Profile::Paper2023
                    && (cell.scenario, cell.planner) == (published.scenario, planner)
                    && (cell.weights.safety, cell.weights.information) == (safety, information)
            })
        };
        let (mdp, greedy) = (&find("mdp")?.numbers, &find("greedy")?.numbers);
        Some(Self {
            table: published.table,
            scenario: published.scenario,
            weights: published.weights,
            of: if published.of_treasures() { "treasures" } else { "steps" },
            paper_t: published.t,
            paper_critical: published.critical,
            paper_claims_rejection: published.claims_rejection,
            paper_recomputed_t: published.from_its_own_numbers(),
            ours: match published.of_treasures() {
                true => welch(&mdp.treasures, &greedy.treasures),
                false => welch(&mdp.steps, &greedy.steps),
            },
        })
    }

    /// What is odd about the paper's value, in a few words.
    #[must_use]
    pub fn oddity(&self) -> Option<&'static str> {
        let t = self.paper_t?;
        let follows = self.paper_recomputed_t.is_some_and(|own| (own - t).abs() < 0.02 * t + 0.01);
        match (self.paper_claims_rejection == (t > self.paper_critical), follows) {
            (false, true) => Some("its text claims the contrary"),
            (false, false) => Some("its text claims the contrary; does not follow from its tables"),
            (true, false) => Some("does not follow from its tables"),
            (true, true) => None,
        }
    }
}

/// The paper's t-tests whose both cells are among `cells`.
pub(crate) fn tests(cells: &[CellFindings<'_>]) -> Vec<TestBeside> {
    paper::tests().filter_map(|published| TestBeside::new(&published, cells)).collect()
}
