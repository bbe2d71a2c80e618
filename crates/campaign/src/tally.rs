//! Statistics of one cell, folded over its trials in memory bounded by the step limit.

use std::collections::BTreeMap;

use contract::Status;
use serde::Serialize;

use crate::Row;
use crate::statistics::{Interval, Sample, wilson};

/// Running counts over the rows of a cell; independent of the order of the rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Trials by outcome, in the order of [`Status::ALL`].
    outcomes: [u64; Status::ALL.len()],
    /// Steps of successful trials, with the number of trials.
    steps: BTreeMap<u64, u64>,
    /// Treasures collected by successful trials, with the number of trials.
    treasures: BTreeMap<u64, u64>,
    hops: u64,
    /// Coverage in millionths, so that the sum is exact.
    coverage_ppm: u64,
}

/// Statistics of the trials of one cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellStatistics {
    /// All missions of the cell, failed ones included.
    pub trials: u64,
    /// Trials that reached the goal.
    pub successes: u64,
    /// Wilson's 95 % interval of the share of successes.
    pub success_interval: Interval,
    /// Failed trials by their final status.
    pub failures: BTreeMap<&'static str, u64>,
    /// Steps of the successful trials.
    pub steps: Sample,
    /// Steps of all trials, each failure counted as the step limit.
    pub restricted_steps: Sample,
    /// Treasures collected by successes.
    pub treasures: Sample,
    /// Successes by how many treasures they collected.
    pub treasure_counts: BTreeMap<u64, u64>,
    /// Mean number of hops over all trials; `None` without trials.
    pub mean_hops: Option<f64>,
    /// Mean share of the map seen over all trials, 0 to 1; `None` without trials.
    pub mean_coverage: Option<f64>,
}

impl Tally {
    /// Adds one trial.
    pub fn fold(&mut self, row: &Row) {
        self.outcomes[row.outcome as usize] += 1;
        if row.outcome == Status::Goal {
            *self.steps.entry(row.steps).or_default() += 1;
            *self.treasures.entry(u64::from(row.treasures)).or_default() += 1;
        }
        self.hops += row.hops;
        self.coverage_ppm += (row.coverage * 1e6).round() as u64;
    }

    /// Number of trials added.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.outcomes.iter().sum()
    }

    /// Number of trials that ended with `outcome`.
    #[must_use]
    pub fn count(&self, outcome: Status) -> u64 {
        self.outcomes[outcome as usize]
    }

    /// Steps of successful trials with the number of trials, ascending.
    pub fn steps(&self) -> impl Iterator<Item = (u64, u64)> + Clone + '_ {
        self.steps.iter().map(|(steps, count)| (*steps, *count))
    }

    /// The statistics; in the restricted mean each failure counts as `steps_max`.
    #[must_use]
    pub fn statistics(&self, steps_max: u64) -> CellStatistics {
        let (trials, successes) = (self.trials(), self.count(Status::Goal));
        let mean = |sum: f64| (trials > 0).then(|| sum / trials as f64);
        let failed = [(steps_max, trials - successes)];
        let failures = Status::ALL
            .into_iter()
            .filter(|status| *status != Status::Goal && self.count(*status) > 0)
            .map(|status| (status.as_str(), self.count(status)));
        CellStatistics {
            trials,
            successes,
            success_interval: wilson(successes, trials),
            failures: failures.collect(),
            steps: Sample::of(self.steps()),
            restricted_steps: Sample::of(self.steps().chain(failed)),
            treasures: Sample::of(self.treasures.iter().map(|(number, count)| (*number, *count))),
            treasure_counts: self.treasures.clone(),
            mean_hops: mean(self.hops as f64),
            mean_coverage: mean(self.coverage_ppm as f64 / 1e6),
        }
    }
}
