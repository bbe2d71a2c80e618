//! The results of one cell: its statistics and its regret.

use contract::{MotionModel, Profile, Weights};
use serde::Serialize;

use crate::tally::CellStatistics;
use crate::{Cell, Tally};

/// The results of one cell. Serialised, its statistics are fields of the cell itself.
#[derive(Clone, Debug, Serialize)]
pub struct CellResults<'a> {
    /// Scenario as the campaign names it.
    pub scenario: &'a str,
    /// Profile: which reading of the model is flown.
    pub profile: Profile,
    /// Name of the algorithm.
    pub planner: &'a str,
    /// Weights of the payoff.
    pub weights: Weights,
    /// Name of the reading of the model's open points, in a campaign that compares some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reading: Option<&'a str>,
    /// What decides where hops end.
    #[serde(skip_serializing_if = "crate::cell::is_law")]
    pub dynamics: MotionModel,
    /// Steps after which a mission ends as a deadlock.
    pub steps_max: u64,
    /// Statistics over the trials.
    #[serde(flatten)]
    pub statistics: CellStatistics,
    /// Distance from the clairvoyant's bounds; `None` where they are not known.
    pub regret: Option<Regret>,
}

impl<'a> CellResults<'a> {
    /// The results of `cell`, compared with the bounds of its terrain if they are known.
    pub(crate) fn new(cell: &'a Cell, tally: &Tally, bound: Option<Bound>) -> Self {
        let statistics = tally.statistics(cell.steps_max);
        Self {
            scenario: &cell.scenario,
            profile: cell.profile,
            planner: &cell.planner,
            weights: cell.weights,
            reading: cell.reading.as_deref(),
            dynamics: cell.dynamics,
            steps_max: cell.steps_max,
            regret: bound.map(|bound| Regret::new(bound, &statistics)),
            statistics,
        }
    }
}

/// The clairvoyant's bounds on one terrain: no planner does better, whatever it knows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Largest probability of success.
    pub success: f64,
    /// Smallest mean of the steps, each failure counted as the step limit.
    pub restricted_mean_steps: f64,
}

/// How far a cell is from its bounds. The two bounds are separate: one planner need not reach both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Regret {
    /// The bounds themselves.
    pub bound: Bound,
    /// Bound of success minus the share of successes; `None` without trials.
    pub success: Option<f64>,
    /// Restricted mean steps minus their bound; `None` without trials.
    pub restricted_mean_steps: Option<f64>,
}

impl Regret {
    fn new(bound: Bound, statistics: &CellStatistics) -> Self {
        let share = (statistics.trials > 0).then(|| statistics.successes as f64 / statistics.trials as f64);
        Self {
            bound,
            success: share.map(|share| bound.success - share),
            restricted_mean_steps: statistics
                .restricted_steps
                .mean
                .map(|mean| mean - bound.restricted_mean_steps),
        }
    }
}
