//! What the trials of one cell come to, folded in memory bounded by the step limit.

use std::collections::BTreeMap;

use contract::Status;
use serde::Serialize;

use crate::Row;
use crate::statistics::{Interval, Sample, wilson};

/// The fold of a cell's rows; it is the same in whatever order they come.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Trials by outcome, in the order of [`Status::ALL`].
    outcomes: [u64; Status::ALL.len()],
    /// Steps of successes: how often each.
    steps: BTreeMap<u64, u64>,
    /// Treasures collected by successes: how often each number.
    treasures: BTreeMap<u64, u64>,
    hops: u64,
    /// Coverage in millionths, so that the sum is exact.
    coverage_ppm: u64,
}

/// A tally in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Numbers {
    /// Trials.
    pub trials: u64,
    /// Trials that reached the goal.
    pub successes: u64,
    /// Wilson's 95 % interval of the share of successes.
    pub success_interval: Interval,
    /// Failures by kind.
    pub failures: BTreeMap<&'static str, u64>,
    /// Steps over successes.
    pub steps: Sample,
    /// Steps with each failure counted at the step limit.
    pub restricted_steps: Sample,
    /// Treasures collected by successes.
    pub treasures: Sample,
    /// Successes by how many treasures they collected.
    pub treasure_counts: BTreeMap<u64, u64>,
    /// Mean hops of all trials.
    pub mean_hops: Option<f64>,
    /// Mean share of the map seen.
    pub mean_coverage: Option<f64>,
}

impl Tally {
    /// Folds in a row.
    pub fn fold(&mut self, row: &Row) {
        self.outcomes[row.outcome as usize] += 1;
        if row.outcome == Status::Goal {
            *self.steps.entry(row.steps).or_default() += 1;
            *self.treasures.entry(u64::from(row.treasures)).or_default() += 1;
        }
        self.hops += row.hops;
        self.coverage_ppm += (row.coverage * 1e6).round() as u64;
    }

    /// Trials folded in.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.outcomes.iter().sum()
    }

    /// Trials that ended so.
    #[must_use]
    pub fn count(&self, outcome: Status) -> u64 {
        self.outcomes[outcome as usize]
    }

    /// Steps of successes with how often each came, rising.
    pub fn steps(&self) -> impl Iterator<Item = (u64, u64)> + Clone + '_ {
        self.steps.iter().map(|(steps, count)| (*steps, *count))
    }

    /// The numbers, with failures counted at `steps_max` in the restricted mean.
    #[must_use]
    pub fn numbers(&self, steps_max: u64) -> Numbers {
        let (trials, successes) = (self.trials(), self.count(Status::Goal));
        let mean = |sum: f64| (trials > 0).then(|| sum / trials as f64);
        let failed = [(steps_max, trials - successes)];
        let failures = Status::ALL
            .into_iter()
            .filter(|status| *status != Status::Goal && self.count(*status) > 0)
            .map(|status| (status.as_str(), self.count(status)));
        Numbers {
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
