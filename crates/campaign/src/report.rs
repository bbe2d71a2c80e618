//! Folds the rows of a campaign and computes its results.

use contract::{Profile, Weights};
use serde::Serialize;

use crate::cell_results::{Bound, CellResults};
use crate::statistics::{Welch, share_difference, welch};
use crate::{Cell, Plan, Row, Tally, TrialPlan};

/// Folds the rows of a campaign in constant memory.
#[derive(Clone, Debug)]
pub struct Report {
    plan: Plan,
    tallies: Vec<Tally>,
}

/// The results of a campaign.
#[derive(Clone, Debug)]
pub struct CampaignResults<'a> {
    /// Name of the campaign.
    pub campaign: &'a str,
    /// Seed of the campaign, which every trial's seed derives from.
    pub seed: u64,
    /// Version of the program that flew it.
    pub version: &'a str,
    /// SHA-256 of the plan, hexadecimal.
    pub hash: &'a str,
    /// Number of trials in the plan.
    pub trials: u64,
    /// Number of trials whose rows were folded in.
    pub flown: u64,
    /// Results of each cell, in the order of the plan.
    pub cells: Vec<CellResults<'a>>,
    /// Tests between planners on the same terrain under the same weights.
    pub planners: Vec<PlannerComparison<'a>>,
}

/// Two planners on the same terrain under the same weights.
#[derive(Clone, Debug, Serialize)]
pub struct PlannerComparison<'a> {
    /// Scenario as the campaign names it.
    pub scenario: &'a str,
    /// Profile of both cells.
    pub profile: Profile,
    /// Weights of both cells.
    pub weights: Weights,
    /// Planner of the earlier cell.
    pub first: &'a str,
    /// Planner of the later cell.
    pub second: &'a str,
    /// Welch's test of their steps over successes, first minus second.
    pub steps: Option<Welch>,
    /// Welch's test of the treasures they collected in successes.
    pub treasures: Option<Welch>,
    /// Difference of their shares of successes, in standard errors.
    pub success_difference_se: Option<f64>,
}

impl Report {
    /// A report on `plan` without any row yet.
    #[must_use]
    pub fn new(plan: Plan) -> Self {
        let tallies = vec![Tally::default(); plan.cells.len()];
        Self { plan, tallies }
    }

    /// Folds in a row; one of an unknown cell is ignored.
    pub fn fold(&mut self, row: &Row) {
        if let Some(tally) = usize::try_from(row.cell).ok().and_then(|cell| self.tallies.get_mut(cell)) {
            tally.fold(row);
        }
    }

    /// The results. `bounds` are those of the cells in their order, `None` or missing where not known.
    #[must_use]
    pub fn results(&self, bounds: &[Option<Bound>]) -> CampaignResults<'_> {
        let cells: Vec<_> = self
            .cells()
            .enumerate()
            .map(|(place, (cell, tally))| {
                let bound = bounds.get(place).copied().flatten();
                CellResults::new(cell, tally, bound)
            })
            .collect();
        CampaignResults {
            campaign: &self.plan.name,
            seed: self.plan.seed,
            version: &self.plan.version,
            hash: &self.plan.hash,
            trials: self.plan.trials(),
            flown: self.tallies.iter().map(Tally::trials).sum(),
            planners: planner_comparisons(&cells),
            cells,
        }
    }

    /// The cells of the plan with their tallies.
    pub fn cells(&self) -> impl Iterator<Item = (&Cell, &Tally)> {
        self.plan.cells.iter().zip(&self.tallies)
    }
}

fn planner_comparisons<'a>(cells: &[CellResults<'a>]) -> Vec<PlannerComparison<'a>> {
    let mut planner_comparisons = Vec::new();
    for (place, first) in cells.iter().enumerate() {
        let same_ground = |second: &&CellResults<'_>| {
            (first.scenario, first.profile, first.weights, first.reading)
                == (second.scenario, second.profile, second.weights, second.reading)
        };
        for second in cells[place + 1..].iter().filter(same_ground) {
            planner_comparisons.push(PlannerComparison {
                scenario: first.scenario,
                profile: first.profile,
                weights: first.weights,
                first: first.planner,
                second: second.planner,
                steps: welch(&first.statistics.steps, &second.statistics.steps),
                treasures: welch(&first.statistics.treasures, &second.statistics.treasures),
                success_difference_se: share_difference(
                    (first.statistics.successes, first.statistics.trials),
                    (second.statistics.successes, second.statistics.trials),
                ),
            });
        }
    }
    planner_comparisons
}
