//! What a campaign says in numbers: cells, tests between planners, regret, the published tables beside.

use contract::{Profile, Weights};
use serde::Serialize;

use crate::against::{Agreement, Beside, TestBeside, agreements, tests};
use crate::paper;
use crate::statistics::{Welch, share_difference, welch};
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
    /// The paper's t-tests beside ours; empty unless asked for.
    pub tests: Vec<TestBeside>,
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
    /// How far it is from what no planner can pass, where that is known.
    pub regret: Option<Regret>,
    /// The paper's cell beside it.
    pub paper: Option<Beside>,
}

/// What no planner can pass in a world, whatever it knows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Largest probability of success.
    pub success: f64,
    /// Least mean of the steps with failures counted at the limit.
    pub restricted_mean_steps: f64,
}

/// A cell beside the bounds of its world. Each bound is one of its own: no planner need reach both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Regret {
    /// The bounds.
    pub bound: Bound,
    /// Bound of success less the share of successes.
    pub success: Option<f64>,
    /// Restricted mean steps less their bound.
    pub restricted_mean_steps: Option<f64>,
}

impl Regret {
    fn new(bound: Bound, numbers: &Numbers) -> Self {
        let share = (numbers.trials > 0).then(|| numbers.successes as f64 / numbers.trials as f64);
        Self {
            bound,
            success: share.map(|share| bound.success - share),
            restricted_mean_steps: numbers
                .restricted_steps
                .mean
                .map(|mean| mean - bound.restricted_mean_steps),
        }
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
    /// Welch's test of the treasures they collected in successes.
    pub treasures: Option<Welch>,
    /// Difference of their shares of successes in standard errors.
    pub success_difference_se: Option<f64>,
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

    /// The numbers, beside the paper's if `against_paper`, with `bounds` of the cells' worlds in the order
    /// of the cells, as far as they are known.
    #[must_use]
    pub fn findings(&self, against_paper: bool, bounds: &[Option<Bound>]) -> Findings<'_> {
        let cells: Vec<_> = self
            .cells()
            .enumerate()
            .map(|(place, (cell, tally))| {
                let bound = bounds.get(place).copied().flatten();
                cell_findings(cell, tally, against_paper, bound)
            })
            .collect();
        Findings {
            campaign: &self.plan.name,
            seed: self.plan.seed,
            version: &self.plan.version,
            hash: &self.plan.hash,
            trials: self.plan.trials(),
            flown: self.tallies.iter().map(Tally::trials).sum(),
            planners: duels(&cells),
            against: if against_paper { agreements(&cells) } else { Vec::new() },
            tests: if against_paper { tests(&cells) } else { Vec::new() },
            cells,
        }
    }

    /// Cells with their tallies.
    pub fn cells(&self) -> impl Iterator<Item = (&Cell, &Tally)> {
        self.plan.cells.iter().zip(&self.tallies)
    }
}

fn cell_findings<'a>(
    cell: &'a Cell,
    tally: &Tally,
    against_paper: bool,
    bound: Option<Bound>,
) -> CellFindings<'a> {
    let numbers = tally.numbers(cell.steps_max);
    let published = paper::published(&cell.scenario, &cell.planner, &cell.weights).filter(|_| against_paper);
    CellFindings {
        scenario: &cell.scenario,
        profile: cell.profile,
        planner: &cell.planner,
        weights: cell.weights,
        steps_max: cell.steps_max,
        paper: published.map(|published| Beside::new(&published, &numbers)),
        regret: bound.map(|bound| Regret::new(bound, &numbers)),
        numbers,
    }
}

fn duels<'a>(cells: &[CellFindings<'a>]) -> Vec<Duel<'a>> {
    let mut duels = Vec::new();
    for (place, first) in cells.iter().enumerate() {
        let same_ground = |second: &&CellFindings<'_>| {
            (first.scenario, first.profile, first.weights)
                == (second.scenario, second.profile, second.weights)
        };
        for second in cells[place + 1..].iter().filter(same_ground) {
            duels.push(Duel {
                scenario: first.scenario,
                profile: first.profile,
                weights: first.weights,
                first: first.planner,
                second: second.planner,
                steps: welch(&first.numbers.steps, &second.numbers.steps),
                treasures: welch(&first.numbers.treasures, &second.numbers.treasures),
                success_difference_se: share_difference(
                    (first.numbers.successes, first.numbers.trials),
                    (second.numbers.successes, second.numbers.trials),
                ),
            });
        }
    }
    duels
}
