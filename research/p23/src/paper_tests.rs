//! The paper's t-tests of greedy against MDP compared with ours.

use campaign::statistics::{Welch, welch};
use contract::Profile;
use serde::Serialize;

use crate::cell_beside_paper::CellBesidePaper;
use crate::tables::{self, PublishedTest};

/// One of the paper's t-tests of greedy against MDP, and ours. The paper prints sizes of t; its tables give the signs.
#[derive(Clone, Debug, Serialize)]
pub struct PaperTest {
    /// Number of the table in the paper.
    pub table: u32,
    /// Name of the built-in scenario.
    pub scenario: &'static str,
    /// Weights w1 and w2.
    pub weights: [f64; 2],
    /// Quantity that is tested: `steps` or `treasures`.
    pub of: &'static str,
    /// The paper's t-value; `None` where it prints a dash.
    pub paper_t: Option<f64>,
    /// Critical value printed in the paper.
    pub paper_critical: f64,
    /// Whether the paper's text claims that the null hypothesis is rejected.
    pub paper_claims_rejection: bool,
    /// Student's t from the paper's own counts, means and deviations: above 0 where the MDP has more.
    pub paper_recomputed_t: Option<f64>,
    /// Welch's test of our trials: above 0 where the MDP has more.
    pub ours: Option<Welch>,
}

impl PaperTest {
    fn new(published: &PublishedTest, cells: &[CellBesidePaper<'_>]) -> Option<Self> {
        let [safety, information] = published.weights;
        let find = |planner| {
            cells.iter().filter(|cell| cell.paper.is_some()).map(|cell| cell.results).find(|cell| {
                cell.profile == Profile::Paper2023
                    && (cell.scenario, cell.planner) == (published.scenario, planner)
                    && (cell.weights.safety, cell.weights.information) == (safety, information)
            })
        };
        let (mdp, greedy) = (&find("mdp")?.statistics, &find("greedy")?.statistics);
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

    /// Inconsistency of the paper's value, in a few words; `None` if there is none.
    #[must_use]
    pub fn oddity(&self) -> Option<&'static str> {
        let t = self.paper_t?;
        let follows = self.paper_recomputed_t.is_some_and(|own| (own.abs() - t).abs() < 0.02 * t + 0.01);
        match (self.paper_claims_rejection == (t > self.paper_critical), follows) {
            (false, true) => Some("its text claims the contrary"),
            (false, false) => Some("its text claims the contrary; does not follow from its tables"),
            (true, false) => Some("does not follow from its tables"),
            (true, true) => None,
        }
    }
}

/// The paper's t-tests for which `cells` has both planners.
pub(crate) fn paper_tests(cells: &[CellBesidePaper<'_>]) -> Vec<PaperTest> {
    tables::tests().filter_map(|published| PaperTest::new(&published, cells)).collect()
}
