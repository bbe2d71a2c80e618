//! Gathers decisions, and tells percentiles, misses and the worst with their causes.

use std::collections::BTreeMap;
use std::fmt;

use contract::{Decision, Name, Stage, Term};
use hdrhistogram::Histogram;
use serde::Serialize;

use super::cause::{Timeline, causes};
use super::{Cause, Happening, Step};
use crate::table;

/// Decisions that are named as the worst.
const WORST: usize = 10;

/// Longest duration that is told apart, nanoseconds: a day.
const DURATION_MAX_NS: u64 = 86_400_000_000_000;

/// Under what conditions the times were taken: a number without them means nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Conditions {
    /// Which clock the moments are of.
    pub clock: String,
    /// The pace that was asked for, if it is known.
    pub pace: Option<String>,
    /// Hops a second from first landing to last commit, as flown.
    pub hops_per_second: Option<f64>,
    /// The processor, if it is known.
    pub processor: Option<String>,
    /// Its cores, if known.
    pub cores: Option<u32>,
    /// Share of all cores that was busy, Hopper's own work included: mean and most over half a second, 0 to 1.
    pub busy_mean: Option<f64>,
    /// See `busy_mean`.
    pub busy_max: Option<f64>,
    /// Most of the kernel's load average over a minute.
    pub load_max: Option<f64>,
    /// Decisions of which the recording tells nothing.
    pub missing: u64,
}

/// The decisions of a mission.
#[derive(Clone, Debug, Default)]
pub struct StepAccount {
    steps: Vec<Step>,
    timeline: Timeline,
}

/// Percentiles of one duration, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
pub struct StageTimes {
    /// Median.
    pub p50_us: f64,
    /// Nine of ten took no longer.
    pub p90_us: f64,
    /// Ninety-nine of a hundred took no longer.
    pub p99_us: f64,
    /// 999 of a thousand took no longer.
    pub p99_9_us: f64,
    /// The longest.
    pub max_us: f64,
    /// The mean.
    pub mean_us: f64,
}

/// The decisions under one planner and term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Group {
    /// The algorithm.
    pub planner: Name,
    /// The term.
    pub term: Term,
    /// Decisions measured.
    pub decisions: u64,
    /// Those that took longer than the budget.
    pub misses: u64,
    /// Landed to committed.
    pub total: StageTimes,
}

/// One of the longest decisions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// The decision.
    pub decision: Decision,
    /// Landed to committed, microseconds.
    pub total_us: f64,
    /// The stage that took most of it.
    pub stage: Stage,
    /// What that stage took, microseconds.
    pub stage_us: f64,
    /// The algorithm in command.
    pub planner: Name,
    /// Its term.
    pub term: Term,
    /// What explains it; empty if nothing known does.
    pub causes: Vec<Cause>,
}

/// Where the time of a mission's decisions went. Displayed, it is text for a terminal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepReport {
    /// Under what conditions.
    pub conditions: Conditions,
    /// Budget of a decision, microseconds.
    pub budget_us: f64,
    /// Decisions measured.
    pub decisions: u64,
    /// Those that took longer than the budget.
    pub misses: u64,
    /// Landed to committed.
    pub total: StageTimes,
    /// Landed to command accepted.
    pub answer: StageTimes,
    /// Each stage, in the order of time.
    pub stages: BTreeMap<Stage, StageTimes>,
    /// By planner and term.
    pub groups: Vec<Group>,
    /// How many decisions each cause touches, and how many of the misses.
    pub causes: BTreeMap<String, (u64, u64)>,
    /// The longest, longest first.
    pub worst: Vec<Worst>,
}

impl StepAccount {
    /// The decisions in order, and what may explain them. Those without a commit were not measured, and are left
    /// out.
    #[must_use]
    pub fn new(steps: impl IntoIterator<Item = Step>, happenings: Vec<Happening>) -> Self {
        let steps = steps.into_iter().filter(|step| step.timing.committed.0 > 0).collect();
        Self { steps, timeline: Timeline::new(happenings) }
    }

    /// The decisions that were measured.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Landed to committed, nanoseconds, as a histogram of three digits.
    #[must_use]
    pub fn histogram(&self) -> Histogram<u64> {
        histogram(self.steps.iter().map(|step| step.timing.total_ns()))
    }

    /// The same as text in the format of HdrHistogram's percentile distributions (`.hgrm`), in milliseconds.
    #[must_use]
    pub fn percentile_distribution(&self) -> String {
        let histogram = self.histogram();
        let ms = |ns: u64| ns as f64 / 1e6;
        let mut text = format!(
            "{:>12} {:>14} {:>10} {:>14}\n\n",
            "Value", "Percentile", "TotalCount", "1/(1-Percentile)"
        );
        for quantile in ladder(histogram.len()) {
            let ns = histogram.value_at_quantile(quantile).min(histogram.max());
            let count = histogram.count_between(0, ns);
            text += &format!("{:12.3} {quantile:2.12} {count:10}", ms(ns));
            text += &if quantile < 1.0 { format!(" {:14.2}\n", 1.0 / (1.0 - quantile)) } else { "\n".into() };
        }
        text + &format!(
            "#[Mean    = {:12.3}, StdDeviation   = {:12.3}]\n#[Max     = {:12.3}, Total count    = {:12}]\n\
             #[Buckets = {:12}, SubBuckets     = {:12}]\n",
            ms(histogram.mean() as u64),
            ms(histogram.stdev() as u64),
            ms(histogram.max()),
            histogram.len(),
            histogram.buckets(),
            histogram.distinct_values()
        )
    }

    /// The report against `budget_ns`.
    #[must_use]
    pub fn report(&self, budget_ns: u64, conditions: Conditions) -> StepReport {
        let is_miss = |step: &Step| step.timing.total_ns() > budget_ns;
        let times = |ns: &dyn Fn(&Step) -> u64| StageTimes::of(self.steps.iter().map(ns));
        let mut explained = BTreeMap::<String, (u64, u64)>::new();
        let mut told = Vec::with_capacity(self.steps.len());
        let mut before = None;
        for step in &self.steps {
            let causes = causes(step, before, &self.timeline);
            for cause in &causes {
                let count = explained.entry(cause.to_string()).or_default();
                *count = (count.0 + 1, count.1 + u64::from(is_miss(step)));
            }
            told.push((step, causes));
            before = Some(step);
        }
        // Stable, so of two that took as long the earlier comes first.
        told.sort_by_key(|(step, _)| std::cmp::Reverse(step.timing.total_ns()));
        let first = self.steps.first().map(|step| step.timing.landed);
        let last = self.steps.last().map(|step| step.timing.committed);
        let flown_s = first.zip(last).map(|(first, last)| last.since_ns(first) as f64 / 1e9);
        let hops_per_second = flown_s.filter(|s| *s > 0.0).map(|s| self.steps.len() as f64 / s);
        StepReport {
            conditions: Conditions { hops_per_second, ..conditions },
            budget_us: us(budget_ns),
            decisions: self.steps.len() as u64,
            misses: self.steps.iter().filter(|step| is_miss(step)).count() as u64,
            total: times(&|step| step.timing.total_ns()),
            answer: times(&|step| step.timing.answer_ns()),
            stages: Stage::ALL
                .into_iter()
                .map(|stage| (stage, times(&|step| step.timing.stages_ns()[stage as usize])))
                .collect(),
            groups: self.groups(budget_ns),
            causes: explained,
            worst: told.into_iter().take(WORST).map(|(step, causes)| worst(step, causes)).collect(),
        }
    }

    fn groups(&self, budget_ns: u64) -> Vec<Group> {
        let mut totals = BTreeMap::<(Term, Name), Vec<u64>>::new();
        for step in &self.steps {
            totals.entry((step.leader.term, step.leader.planner)).or_default().push(step.timing.total_ns());
        }
        let group = |((term, planner), totals): ((Term, Name), Vec<u64>)| Group {
            planner,
            term,
            decisions: totals.len() as u64,
            misses: totals.iter().filter(|ns| **ns > budget_ns).count() as u64,
            total: StageTimes::of(totals.into_iter()),
        };
        totals.into_iter().map(group).collect()
    }
}

impl StageTimes {
    pub(super) fn of(durations_ns: impl Iterator<Item = u64>) -> Self {
        let histogram = histogram(durations_ns);
        // A bucket's upper end may lie above the largest value recorded; no percentile does.
        let quantile = |share| us(histogram.value_at_quantile(share).min(histogram.max()));
        Self {
            p50_us: quantile(0.50),
            p90_us: quantile(0.90),
            p99_us: quantile(0.99),
            p99_9_us: quantile(0.999),
            max_us: us(histogram.max()),
            mean_us: histogram.mean() / 1e3,
        }
    }
}

/// Quantiles from 0 to 1, five on each half of the way that is left, as far as `count` decisions tell them apart.
fn ladder(count: u64) -> Vec<f64> {
    let mut quantiles = Vec::new();
    let mut left = 1.0;
    while left * count as f64 >= 1.0 {
        quantiles.extend((0..5).map(|tick| 1.0 - left + left / 2.0 * f64::from(tick) / 5.0));
        left /= 2.0;
    }
    quantiles.push(1.0);
    quantiles
}

fn histogram(durations_ns: impl Iterator<Item = u64>) -> Histogram<u64> {
    let mut histogram = Histogram::new(3).expect("three digits are within 0 to 5");
    for ns in durations_ns {
        histogram.record(ns.min(DURATION_MAX_NS)).expect("the histogram grows to a day");
    }
    histogram
}

fn worst(step: &Step, causes: Vec<Cause>) -> Worst {
    let stages = step.timing.stages_ns();
    let longest = (0..stages.len()).rev().max_by_key(|stage| stages[*stage]).unwrap_or(0);
    Worst {
        decision: step.decision,
        total_us: us(step.timing.total_ns()),
        stage: Stage::ALL[longest],
        stage_us: us(stages[longest]),
        planner: step.leader.planner,
        term: step.leader.term,
        causes,
    }
}

fn us(ns: u64) -> f64 {
    ns as f64 / 1e3
}

fn ms(us: f64) -> String {
    format!("{:.3}", us / 1e3)
}

impl fmt::Display for StepReport {
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

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{Incarnation, Leader, MonotonicNs, Origin, Role, Timing};

    /// A decision that landed at `landed_us` and took `plan_us` to plan and 10 µs for all else.
    fn step(decision: u64, landed_us: u64, plan_us: u64, life: u64, planner: &str) -> Step {
        let moments = [0, 1, 2, 3, 4, 4 + plan_us, 7 + plan_us, 10 + plan_us];
        Step {
            decision: Decision(decision),
            leader: Leader {
                term: Term(life),
                incarnation: Incarnation(life),
                pid: 1,
                planner: planner.parse().unwrap(),
            },
            origin: Origin::Planner,
            vetoes: 0,
            work: 1,
            cut: false,
            timing: Timing::from_moments(moments.map(|us| MonotonicNs(1000 * (1 + landed_us + us)))),
        }
    }

    /// 1,000 decisions a millisecond apart: life 1 of mdp, from 600 on life 2, from 800 on greedy.
    fn account() -> StepAccount {
        let steps = (0..1000).map(|n| {
            let (life, planner) = match n {
                0..600 => (1, "mdp"),
                600..800 => (2, "mdp"),
                _ => (3, "greedy"),
            };
            let plan_us = if n == 0 || n == 600 { 700 } else { n % 100 };
            Step { vetoes: u64::from(n == 42), ..step(n, 1000 * n, plan_us, life, planner) }
        });
        let happening = |ms: u64, cause| {
            let from = MonotonicNs(1_000_000 * ms);
            Happening { from, until: from.plus_ns(1_000), cause }
        };
        let happenings =
            vec![happening(600, Cause::HostLoad), happening(77, Cause::Restart(Role::Perception))];
        StepAccount::new(steps, happenings)
    }

    /// P-LATENCY-REPORT: percentiles, misses and causes are those of the decisions.
    #[test]
    fn the_worst_decisions_are_named_with_their_causes() {
        let report = account().report(600_000, Conditions::default());
        assert_eq!((report.decisions, report.misses), (1000, 2));
        let worst: Vec<(u64, Vec<Cause>)> =
            report.worst.iter().take(2).map(|worst| (worst.decision.0, worst.causes.clone())).collect();
        assert_eq!(
            worst,
            [
                (0, vec![Cause::FirstPlan]),
                (600, vec![Cause::FirstPlan, Cause::PlannerRestart, Cause::HostLoad])
            ]
        );
        assert!(report.worst.iter().all(|worst| worst.stage == Stage::Plan));
        assert_eq!(report.worst.len(), 10);
        assert_eq!(report.causes["swap"], (1, 0));
        assert_eq!(report.causes["first plan"], (3, 2));
        assert_eq!(report.causes["veto"], (1, 0));
        assert_eq!(report.causes["perception restart"], (1, 0));
        let groups: Vec<(&str, u64, u64, u64)> =
            report.groups.iter().map(|g| (g.planner.as_str(), g.term.0, g.decisions, g.misses)).collect();
        assert_eq!(groups, [("mdp", 1, 600, 1), ("mdp", 2, 200, 1), ("greedy", 3, 200, 0)]);
        for (got, need) in
            [(report.total.p50_us, 60.0), (report.total.p99_us, 109.0), (report.total.max_us, 710.0)]
        {
            assert!((got / need - 1.0).abs() < 0.02, "{got} {need}");
        }
        let hops = report.conditions.hops_per_second.unwrap();
        assert!((hops - 1000.0).abs() < 2.0, "{hops}");
        let text = report.to_string();
        assert!(
            text.contains("2 of 1000 took longer") && text.contains("first plan, planner restart"),
            "{text}"
        );
    }

    /// Against a look at every happening: long ones, short ones, and decisions whose clock began anew.
    #[test]
    fn every_happening_that_touches_a_decision_is_found() {
        let roles = Role::ALL;
        // A mixing of numbers, so that lengths and begins are in no order.
        let mixed = |n: u64, below: u64| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) % below;
        let happenings: Vec<Happening> = (0..400)
            .map(|n| {
                let from = MonotonicNs(1_000 * mixed(n, 120_000));
                let length_us = if n % 50 == 0 { 30_000 } else { mixed(n + 7, 900) };
                let cause = Cause::Restart(roles[n as usize % roles.len()]);
                Happening { from, until: from.plus_ns(1_000 * length_us), cause }
            })
            .collect();
        let timeline = Timeline::new(happenings.clone());
        let mut touched = 0;
        for n in 0..300_u64 {
            // From 200 on the clock has begun anew.
            let step = step(n, 500 * (n % 200), mixed(n, 700), 1, "mdp");
            let moments = (step.timing.landed, step.timing.committed);
            let all = happenings.iter().filter(|one| one.from <= moments.1 && one.until >= moments.0);
            let mut need: Vec<Cause> = all.map(|happening| happening.cause).collect();
            need.sort_unstable();
            need.dedup();
            touched += need.len();
            assert_eq!(causes(&step, Some(&step), &timeline), need, "decision {n}");
        }
        assert!(touched > 300, "{touched}");
    }

    #[test]
    fn a_percentile_distribution_ends_with_all_decisions_at_the_maximum() {
        let text = account().percentile_distribution();
        let last = text.lines().rfind(|line| !line.starts_with('#')).unwrap();
        let fields: Vec<f64> = last.split_whitespace().map(|field| field.parse().unwrap()).collect();
        assert_eq!(fields[1..3], [1.0, 1000.0]);
        assert!((fields[0] - 0.710).abs() < 0.002, "{last}");
        let counts: Vec<f64> = (text.lines().skip(2).filter(|line| !line.starts_with('#')))
            .map(|line| line.split_whitespace().nth(2).unwrap().parse().unwrap())
            .collect();
        assert!(counts.len() > 40 && counts.is_sorted(), "{text}");
    }

    #[test]
    fn nothing_measured_is_said_so() {
        let account =
            StepAccount::new([Step { timing: Timing::default(), ..step(0, 0, 0, 1, "mdp") }], Vec::new());
        let report = account.report(1, Conditions::default());
        assert_eq!((report.decisions, report.misses), (0, 0));
        assert!(report.to_string().contains("Nothing was measured"), "{report}");
        assert!(account.percentile_distribution().contains("Total count"));
    }
}
