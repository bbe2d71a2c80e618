//! The report of `hopper latency report`.

use std::collections::BTreeMap;
use std::fmt;

use contract::{Decision, Name, Stage, Term};
use serde::Serialize;

use super::Cause;
use crate::histogram::us;
use crate::table;

/// Conditions under which the times were measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Conditions {
    /// Clock that the times are from.
    pub clock: String,
    /// Pace asked for: `max`, `real`, a multiple of it, or landings a second; `None` if not known.
    pub pace: Option<String>,
    /// Hops per second actually flown, from first landing to last commit.
    pub hops_per_second: Option<f64>,
    /// Name of the processor; `None` if not known.
    pub processor: Option<String>,
    /// Number of cores; `None` if not known.
    pub cores: Option<u32>,
    /// Mean share of all cores that was busy, Hopper included, 0 to 1.
    pub busy_mean: Option<f64>,
    /// Largest share of all cores that was busy over half a second, 0 to 1.
    pub busy_max: Option<f64>,
    /// Largest one-minute load average of the kernel.
    pub load_max: Option<f64>,
    /// Number of decisions missing from the recording.
    pub missing: u64,
}

/// Percentiles of one duration, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
pub struct StageTimes {
    /// Median.
    pub p50_us: f64,
    /// 90th percentile.
    pub p90_us: f64,
    /// 99th percentile.
    pub p99_us: f64,
    /// 99.9th percentile.
    pub p99_9_us: f64,
    /// Maximum.
    pub max_us: f64,
    /// Arithmetic mean.
    pub mean_us: f64,
}

/// Timing of the decisions of one planner in one term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Name of the algorithm.
    pub planner: Name,
    /// Term in which it commanded.
    pub term: Term,
    /// Number of decisions measured.
    pub decisions: u64,
    /// Number of decisions longer than the budget.
    pub misses: u64,
    /// Times from landing to commit.
    pub total: StageTimes,
}

/// One of the longest decisions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Number of the decision, from 0.
    pub decision: Decision,
    /// Time from landing to commit, microseconds.
    pub total_us: f64,
    /// The longest stage.
    pub stage: Stage,
    /// Duration of that stage, microseconds.
    pub stage_us: f64,
    /// Who commanded the decisions measured.
    pub planner: Name,
    /// Term of the planner in command.
    pub term: Term,
    /// Known causes; empty if none is known.
    pub causes: Vec<Cause>,
}

/// Timing of all decisions of a mission. Displayed, it is text for a terminal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DecisionReport {
    /// Conditions of the measurement.
    pub conditions: Conditions,
    /// Budget of a decision, microseconds.
    pub budget_us: f64,
    /// Number of decisions measured.
    pub decisions: u64,
    /// Number of decisions longer than the budget.
    pub misses: u64,
    /// Times from landing to commit.
    pub total: StageTimes,
    /// Times from landing to the accepted command.
    pub answer: StageTimes,
    /// Times of each stage, in chronological order.
    pub stages: BTreeMap<Stage, StageTimes>,
    /// Totals by planner and term.
    pub groups: Vec<Group>,
    /// For each cause the number of decisions, and of missed budgets, that it may explain.
    pub causes: BTreeMap<String, (u64, u64)>,
    /// The longest decisions, longest first.
    pub worst: Vec<Worst>,
}

impl StageTimes {
    /// By nearest rank, exact to the nanosecond: every decision is at hand.
    pub(super) fn of(durations_ns: impl Iterator<Item = u64>) -> Self {
        let mut sorted: Vec<u64> = durations_ns.collect();
        sorted.sort_unstable();
        let Some(&max) = sorted.last() else { return Self::default() };
        let quantile = |share: f64| {
            let rank = (share * sorted.len() as f64).ceil() as usize;
            us(sorted[rank.max(1) - 1])
        };
        let sum: u128 = sorted.iter().map(|ns| u128::from(*ns)).sum();
        Self {
            p50_us: quantile(0.50),
            p90_us: quantile(0.90),
            p99_us: quantile(0.99),
            p99_9_us: quantile(0.999),
            max_us: us(max),
            mean_us: sum as f64 / sorted.len() as f64 / 1e3,
        }
    }
}

fn ms(us: f64) -> String {
    format!("{:.3}", us / 1e3)
}

impl fmt::Display for DecisionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.conditions)?;
        if self.decisions == 0 {
            return writeln!(f, "Nothing was measured.");
        }
        let budget_ms = self.budget_us / 1e3;
        let (misses, decisions) = (self.misses, self.decisions);
        writeln!(
            f,
            "Budget of {budget_ms} ms a decision: {misses} of {decisions} took longer. Times in ms.\n"
        )?;
        let row = |name: &str, times: &StageTimes| {
            let [p50, p90, p99, p99_9, max, mean] =
                [times.p50_us, times.p90_us, times.p99_us, times.p99_9_us, times.max_us, times.mean_us]
                    .map(ms);
            [name.to_owned(), p50, p90, p99, p99_9, max, mean]
        };
        let mut rows: Vec<_> = self.stages.iter().map(|(stage, times)| row(stage.as_str(), times)).collect();
        rows.push(row("answer", &self.answer));
        rows.push(row("total", &self.total));
        writeln!(f, "{}", table(["stage", "p50", "p90", "p99", "p99.9", "max", "mean"], &rows))?;
        let rows: Vec<_> = self.groups.iter().map(Group::row).collect();
        let headings = ["planner", "term", "decisions", "missed", "p50", "p99", "max"];
        writeln!(f, "{}", table(headings, &rows))?;
        let rows: Vec<_> = self.worst.iter().map(Worst::row).collect();
        f.write_str(&table(
            ["decision", "total", "longest stage", "of it", "planner", "term", "causes"],
            &rows,
        ))
    }
}

impl Group {
    fn row(&self) -> [String; 7] {
        let Group { planner, term, decisions, misses, total } = self;
        [
            planner.to_string(),
            term.to_string(),
            decisions.to_string(),
            misses.to_string(),
            ms(total.p50_us),
            ms(total.p99_us),
            ms(total.max_us),
        ]
    }
}

impl Worst {
    fn row(&self) -> [String; 7] {
        let causes: Vec<String> = self.causes.iter().map(Cause::to_string).collect();
        [
            self.decision.to_string(),
            ms(self.total_us),
            self.stage.to_string(),
            ms(self.stage_us),
            self.planner.to_string(),
            self.term.to_string(),
            if causes.is_empty() { "unknown".into() } else { causes.join(", ") },
        ]
    }
}

impl fmt::Display for Conditions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Clock: {}. Pace: {}", self.clock, self.pace.as_deref().unwrap_or("not known"))?;
        if let Some(hops) = self.hops_per_second {
            write!(f, ", {hops:.1} hops a second as flown")?;
        }
        write!(f, ".\nHost: {}", self.processor.as_deref().unwrap_or("processor not known"))?;
        if let Some(cores) = self.cores {
            write!(f, ", {cores} cores")?;
        }
        match (self.busy_mean, self.busy_max) {
            (Some(mean), Some(max)) => {
                write!(f, ", busy {:.0} % in the mean, {:.0} % at most", 100.0 * mean, 100.0 * max)?;
            }
            _ => write!(f, ", how busy is not known")?,
        }
        if let Some(load) = self.load_max {
            write!(f, ", load average up to {load:.2}")?;
        }
        write!(f, ".")?;
        if self.missing > 0 {
            write!(f, "\n{} decisions are missing, and not in any number here.", self.missing)?;
        }
        Ok(())
    }
}
