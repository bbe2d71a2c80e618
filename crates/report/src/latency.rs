//! Latency histograms of a mission: the whole decision and each of its stages.
//!
//! The budget applies to a decision, from landing to commit. The papers count steps, two or three to a hop, with
//! 0.6 s each; [`PerStep`] divides the same times by the steps.

use std::collections::BTreeMap;
use std::fmt;

use contract::{Stage, Timing};
use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

use crate::histogram::{self, us};
use crate::table;

/// Histograms over decisions. Memory depends on the range of the durations, not on their number.
#[derive(Clone, Debug, PartialEq)]
pub struct Latency {
    budget_ns: u64,
    misses: u64,
    misses_per_step: u64,
    total: Distribution,
    answer: Distribution,
    feeding: Distribution,
    per_step: Distribution,
    stages: [Distribution; Stage::ALL.len()],
}

impl Latency {
    /// Empty histograms, with a budget of `budget_ns` for a decision or, as the papers count, for a step.
    #[must_use]
    pub fn new(budget_ns: u64) -> Self {
        Self {
            budget_ns,
            misses: 0,
            misses_per_step: 0,
            total: Distribution::new(),
            answer: Distribution::new(),
            feeding: Distribution::new(),
            per_step: Distribution::new(),
            stages: std::array::from_fn(|_| Distribution::new()),
        }
    }

    /// Records a decision that cost `steps` of the papers' steps. A timing without a commit time was not measured
    /// (lockstep has no clock) and is ignored.
    pub fn record(&mut self, timing: &Timing, steps: u64) {
        if timing.committed.0 == 0 {
            return;
        }
        let total_ns = timing.total_ns();
        let per_step_ns = total_ns / steps.max(1);
        self.misses += u64::from(total_ns > self.budget_ns);
        self.misses_per_step += u64::from(per_step_ns > self.budget_ns);
        self.total.record(total_ns);
        self.per_step.record(per_step_ns);
        self.answer.record(timing.answer_ns());
        self.feeding.record(timing.feeding_ns());
        for (stage, ns) in self.stages.iter_mut().zip(timing.stages_ns()) {
            stage.record(ns);
        }
    }

    /// Number of decisions recorded.
    #[must_use]
    pub fn decisions(&self) -> u64 {
        self.total.histogram.len()
    }

    /// Number of decisions that took longer than the budget.
    #[must_use]
    pub fn misses(&self) -> u64 {
        self.misses
    }

    /// Percentiles of the time from landing to commit.
    #[must_use]
    pub fn total(&self) -> Percentiles {
        self.total.percentiles()
    }

    /// Percentiles of everything recorded.
    #[must_use]
    pub fn report(&self) -> LatencyReport {
        let stages = Stage::ALL.into_iter().zip(&self.stages);
        LatencyReport {
            budget_us: us(self.budget_ns),
            decisions: self.decisions(),
            misses: self.misses,
            total: self.total(),
            answer: self.answer.percentiles(),
            feeding: self.feeding.percentiles(),
            stages: stages.map(|(stage, spent)| (stage, spent.percentiles())).collect(),
            per_step: PerStep { misses: self.misses_per_step, percentiles: self.per_step.percentiles() },
        }
    }
}

/// One duration over many decisions: percentiles to three digits, maximum and sum exact to the nanosecond.
#[derive(Clone, Debug, PartialEq)]
struct Distribution {
    histogram: Histogram<u64>,
    max_ns: u64,
    sum_ns: u128,
}

impl Distribution {
    fn new() -> Self {
        Self { histogram: histogram::empty(), max_ns: 0, sum_ns: 0 }
    }

    fn record(&mut self, ns: u64) {
        histogram::record(&mut self.histogram, ns);
        self.max_ns = self.max_ns.max(ns);
        self.sum_ns += u128::from(ns);
    }

    fn percentiles(&self) -> Percentiles {
        // A bucket's upper end may exceed the largest value recorded; a percentile must not.
        let quantile = |share| us(self.histogram.value_at_quantile(share).min(self.max_ns));
        let decisions = u128::from(self.histogram.len().max(1));
        Percentiles {
            p50_us: quantile(0.50),
            p90_us: quantile(0.90),
            p99_us: quantile(0.99),
            max_us: us(self.max_ns),
            mean_us: us(((self.sum_ns + decisions / 2) / decisions) as u64),
        }
    }
}

/// Percentiles of one duration, microseconds; all zero where nothing was measured.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Percentiles {
    /// Median.
    pub p50_us: f64,
    /// 90th percentile.
    pub p90_us: f64,
    /// 99th percentile.
    pub p99_us: f64,
    /// Maximum.
    pub max_us: f64,
    /// Mean. The means of the stages sum to the mean of the total; percentiles do not.
    pub mean_us: f64,
}

/// The total of a decision divided by the steps it cost, as the papers count.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct PerStep {
    /// Number of decisions whose time per step exceeded the budget.
    pub misses: u64,
    /// Time from landing to commit divided by the steps.
    #[serde(flatten)]
    pub percentiles: Percentiles,
}

/// Latency of a mission. Serialised, its names are promised to programs; displayed, it is a table of the stages
/// against the budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatencyReport {
    /// Budget of a decision, microseconds.
    pub budget_us: f64,
    /// Number of decisions measured.
    pub decisions: u64,
    /// Number of decisions that took longer than the budget.
    pub misses: u64,
    /// Time from landing to commit.
    pub total: Percentiles,
    /// Time from landing to the accepted command.
    #[serde(default)]
    pub answer: Percentiles,
    /// Time from publishing the state to the start of planning: the cost of bringing a landing to the planner.
    #[serde(default)]
    pub feeding: Percentiles,
    /// Time of each stage, in chronological order.
    pub stages: BTreeMap<Stage, Percentiles>,
    /// Time per step, as the papers count.
    pub per_step: PerStep,
}

impl LatencyReport {
    /// Share of the total spent in `stage`, 0 to 1; 0 if nothing was measured.
    #[must_use]
    pub fn share(&self, stage: Stage) -> f64 {
        let mean_us = self.stages.get(&stage).map_or(0.0, |spent| spent.mean_us);
        if self.total.mean_us > 0.0 { mean_us / self.total.mean_us } else { 0.0 }
    }

    fn row(&self, name: &str, span: &str, spent: &Percentiles, share: String) -> [String; 8] {
        let ms = |us: f64| format!("{:.3}", us / 1e3);
        let of_budget = match self.budget_us > 0.0 {
            true => percent(spent.p99_us / self.budget_us),
            false => String::new(),
        };
        let [p50, p90, p99, max] = [spent.p50_us, spent.p90_us, spent.p99_us, spent.max_us].map(ms);
        [name.into(), span.into(), p50, p90, p99, max, share, of_budget]
    }
}

impl fmt::Display for LatencyReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.decisions == 0 {
            return writeln!(f, "Latency: nothing was measured.");
        }
        let budget_ms = self.budget_us / 1e3;
        writeln!(
            f,
            "Latency in ms; {} of {} decisions missed the budget of {budget_ms} ms (last column: p99).",
            self.misses, self.decisions
        )?;
        let mut rows: Vec<_> = self
            .stages
            .iter()
            .map(|(&stage, spent)| self.row(stage.as_str(), span(stage), spent, percent(self.share(stage))))
            .collect();
        let share = |spent: &Percentiles| percent(spent.mean_us / self.total.mean_us.max(f64::MIN_POSITIVE));
        rows.push(self.row("feeding", "state to planning", &self.feeding, share(&self.feeding)));
        rows.push(self.row("answer", "landed to accepted", &self.answer, share(&self.answer)));
        rows.push(self.row("total", "since landed", &self.total, percent(1.0)));
        rows.push(self.row("a step", "in the paper's count", &self.per_step.percentiles, String::new()));
        let headings = ["stage", "until", "p50", "p90", "p99", "max", "share", "of budget"];
        f.write_str(&table(headings, &rows))
    }
}

fn percent(share: f64) -> String {
    let tiny = share > 0.0 && share < 0.001;
    if tiny { "<0.1 %".into() } else { format!("{:.1} %", 100.0 * share) }
}

/// The event that ends a stage, in words; for the first stage the one that begins it too.
fn span(stage: Stage) -> &'static str {
    match stage {
        Stage::State => "landed to state published",
        Stage::Sense => "to ground sensed",
        Stage::Map => "to map published",
        Stage::Deliver => "to planning started",
        Stage::Plan => "to planning ended",
        Stage::Command => "to command accepted",
        Stage::Commit => "to committed",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::MonotonicNs;

    fn timing(moments_us: [u64; 8]) -> Timing {
        Timing::from_moments(moments_us.map(|us| MonotonicNs(us * 1000)))
    }

    #[test]
    fn means_of_the_stages_sum_to_the_mean_of_the_total() {
        let mut latency = Latency::new(600_000_000);
        for i in 0..1000_u64 {
            let moments = [0, 3, 10 + i % 7, 20 + i, 30 + i, 100 + 3 * i, 110 + 3 * i, 131 + 3 * i];
            latency.record(&timing(moments.map(|us| us + 5000 * i)), 2);
        }
        latency.record(&timing([10, 0, 99, 0, 30, 0, 31, 38]), 2);
        let report = latency.report();
        let sum_us: f64 = report.stages.values().map(|spent| spent.mean_us).sum();
        // Each mean is rounded to the nanosecond.
        assert!((sum_us - report.total.mean_us).abs() <= 0.5e-3 * 8.0, "{sum_us} {}", report.total.mean_us);
        let shares: f64 = Stage::ALL.into_iter().map(|stage| report.share(stage)).sum();
        assert!((shares - 1.0).abs() < 1e-3, "{shares}");
    }

    #[test]
    fn a_decision_misses_its_budget_only_beyond_it() {
        let mut latency = Latency::new(600_000_000);
        latency.record(&timing([0, 0, 0, 0, 0, 0, 0, 600_000]), 2);
        assert_eq!(latency.misses(), 0);
        latency.record(&timing([0, 0, 0, 0, 0, 0, 0, 600_001]), 2);
        assert_eq!(latency.misses(), 1);
        assert_eq!(latency.report().per_step.misses, 0, "two steps of 0.3 s are within the papers' reading");
        latency.record(&timing([0, 0, 0, 0, 0, 0, 0, 1_800_003]), 3);
        let report = latency.report();
        assert_eq!((report.misses, report.per_step.misses), (2, 1));
        assert_eq!(report.per_step.percentiles.max_us, 600_001.0);
    }

    #[test]
    fn percentiles_keep_three_digits_and_never_pass_the_maximum() {
        let mut latency = Latency::new(1);
        for us in 1..=10_000 {
            latency.record(&timing([5, 5, 5, 5, 5, 5, 5, 5 + us]), 2);
        }
        let total = latency.report().total;
        for (got, need) in [(total.p50_us, 5000.0), (total.p90_us, 9000.0), (total.p99_us, 9900.0)] {
            assert!((got / need - 1.0_f64).abs() < 1e-3, "{got} {need}");
        }
        assert_eq!(total.max_us, 10_000.0);
        let mut single = Latency::new(1);
        single.record(&timing([0, 0, 0, 0, 0, 0, 0, 599_999]), 1);
        let total = single.report().total;
        assert_eq!([total.p50_us, total.p99_us, total.max_us], [599_999.0; 3]);
    }

    #[test]
    fn nothing_measured_gives_zeros() {
        let mut latency = Latency::new(600_000_000);
        latency.record(&Timing::default(), 2);
        let report = latency.report();
        assert_eq!((report.decisions, report.misses), (0, 0));
        assert_eq!(report.total, Percentiles::default());
        assert_eq!(report.stages.len(), Stage::ALL.len());
        assert!(report.stages.values().all(|spent| *spent == Percentiles::default()));
        assert_eq!(report.share(Stage::Plan), 0.0);
        assert_eq!(report.to_string(), "Latency: nothing was measured.\n");
    }

    #[test]
    fn a_duration_beyond_belief_is_kept_and_counted() {
        let mut latency = Latency::new(1);
        latency.record(&timing([1, 1, 1, 1, 1, 1, 1, u64::MAX / 1000]), 2);
        let report = latency.report();
        assert_eq!((report.decisions, report.misses), (1, 1));
        assert!(report.total.max_us > 1e15);
    }

    #[test]
    fn the_json_names_are_those_promised() {
        let mut latency = Latency::new(600_000_000);
        latency.record(&timing([10, 11, 13, 16, 20, 25, 31, 38]), 2);
        let json = serde_json::to_value(latency.report()).unwrap();
        assert_eq!(json["budget_us"], 600_000.0);
        assert_eq!(json["decisions"], 1);
        assert_eq!(json["misses"], 0);
        assert_eq!((&json["answer"]["p50_us"], &json["feeding"]["p50_us"]), (&21.0.into(), &9.0.into()));
        for name in ["p50_us", "p90_us", "p99_us", "max_us"] {
            assert_eq!(json["total"][name], 28.0, "{name}");
            assert_eq!(json["per_step"][name], 14.0, "{name}");
        }
        let stages = ["state", "sense", "map", "deliver", "plan", "command", "commit"];
        for (n, stage) in stages.into_iter().enumerate() {
            assert_eq!(json["stages"][stage]["p50_us"], (n + 1) as f64, "{stage}");
        }
        let text = serde_json::to_string(&latency.report()).unwrap();
        let places: Vec<_> =
            stages.iter().map(|stage| text.find(&format!("{stage:?}:{{")).unwrap()).collect();
        assert!(places.is_sorted(), "stages stand in the order of time: {text}");
        assert_eq!(serde_json::from_str::<LatencyReport>(&text).unwrap(), latency.report());
    }
}
