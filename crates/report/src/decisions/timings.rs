//! The timing of every decision of a mission.

use std::collections::BTreeMap;

use contract::{Name, RobotId, Stage, Term};
use hdrhistogram::Histogram;

use super::cause::{Timeline, causes};
use super::report::{Conditions, DecisionReport, Group, StageTimes, Worst};
use super::{Cause, DecisionTiming, Disturbance};
use crate::flown_time::FlownTime;
use crate::histogram::{histogram, us};

/// Number of decisions listed as the longest.
const WORST: usize = 10;

/// The timing of every measured decision of a mission.
#[derive(Clone, Debug, Default)]
pub struct DecisionTimings {
    decisions: Vec<DecisionTiming>,
    timeline: Timeline,
}

impl DecisionTimings {
    /// `decisions` in order, and the disturbances that may explain them. Decisions without a commit time were not
    /// measured and are left out.
    #[must_use]
    pub fn new(decisions: impl IntoIterator<Item = DecisionTiming>, disturbances: Vec<Disturbance>) -> Self {
        let decisions = decisions.into_iter().filter(|timed| timed.timing.committed.0 > 0).collect();
        Self { decisions, timeline: Timeline::new(disturbances) }
    }

    /// The measured decisions, in order.
    #[must_use]
    pub fn decisions(&self) -> &[DecisionTiming] {
        &self.decisions
    }

    /// Histogram of the times from landing to commit, nanoseconds, with three significant digits.
    #[must_use]
    pub fn histogram(&self) -> Histogram<u64> {
        histogram(self.decisions.iter().map(|timed| timed.timing.total_ns()))
    }

    /// [`DecisionTimings::histogram`] as text in the format of HdrHistogram's percentile distributions (`.hgrm`),
    /// milliseconds.
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

    /// The report against a budget of `budget_ns` for each decision.
    #[must_use]
    pub fn report(&self, budget_ns: u64, conditions: Conditions) -> DecisionReport {
        let is_miss = |timed: &DecisionTiming| timed.timing.total_ns() > budget_ns;
        let times = |ns: &dyn Fn(&DecisionTiming) -> u64| StageTimes::of(self.decisions.iter().map(ns));
        let mut explained = BTreeMap::<String, (u64, u64)>::new();
        let mut told = Vec::with_capacity(self.decisions.len());
        // Of each robot: its planner is another than that of the robot before it.
        let mut before: BTreeMap<RobotId, &DecisionTiming> = BTreeMap::new();
        for timed in &self.decisions {
            let causes = causes(timed, before.insert(timed.robot, timed), &self.timeline);
            for cause in &causes {
                let count = explained.entry(cause.to_string()).or_default();
                *count = (count.0 + 1, count.1 + u64::from(is_miss(timed)));
            }
            told.push((timed, causes));
        }
        // The sort is stable: of two equally long decisions the earlier comes first.
        told.sort_by_key(|(timed, _)| std::cmp::Reverse(timed.timing.total_ns()));
        let flown_ns = FlownTime::of(self.decisions.iter().map(|timed| &timed.timing)).ns();
        let hops_per_second = (flown_ns > 0).then(|| self.decisions.len() as f64 / (flown_ns as f64 / 1e9));
        DecisionReport {
            conditions: Conditions { hops_per_second, ..conditions },
            budget_us: us(budget_ns),
            decisions: self.decisions.len() as u64,
            misses: self.decisions.iter().filter(|timed| is_miss(timed)).count() as u64,
            total: times(&|timed| timed.timing.total_ns()),
            answer: times(&|timed| timed.timing.answer_ns()),
            stages: Stage::ALL
                .into_iter()
                .map(|stage| (stage, times(&|timed| timed.timing.stages_ns()[stage as usize])))
                .collect(),
            groups: self.groups(budget_ns),
            causes: explained,
            worst: told.into_iter().take(WORST).map(|(timed, causes)| worst(timed, causes)).collect(),
        }
    }

    fn groups(&self, budget_ns: u64) -> Vec<Group> {
        let mut totals = BTreeMap::<(Term, Name), Vec<u64>>::new();
        for timed in &self.decisions {
            totals
                .entry((timed.leader.term, timed.leader.planner))
                .or_default()
                .push(timed.timing.total_ns());
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

/// Quantiles from 0 to 1, five in each half of what remains, as far as `count` decisions can resolve them.
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

fn worst(timed: &DecisionTiming, causes: Vec<Cause>) -> Worst {
    let stages = timed.timing.stages_ns();
    let longest = (0..stages.len()).rev().max_by_key(|stage| stages[*stage]).unwrap_or(0);
    Worst {
        decision: timed.decision,
        total_us: us(timed.timing.total_ns()),
        stage: Stage::ALL[longest],
        stage_us: us(stages[longest]),
        planner: timed.leader.planner,
        term: timed.leader.term,
        causes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{Decision, Incarnation, Leader, MonotonicNs, Origin, Role, Timing};

    /// A decision that landed at `landed_us` and took `plan_us` to plan and 10 µs for all else.
    fn timed(decision: u64, landed_us: u64, plan_us: u64, life: u64, planner: &str) -> DecisionTiming {
        let moments = [0, 1, 2, 3, 4, 4 + plan_us, 7 + plan_us, 10 + plan_us];
        DecisionTiming {
            robot: RobotId(0),
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
    fn timings() -> DecisionTimings {
        let decisions = (0..1000).map(|n| {
            let (life, planner) = match n {
                0..600 => (1, "mdp"),
                600..800 => (2, "mdp"),
                _ => (3, "greedy"),
            };
            let plan_us = if n == 0 || n == 600 { 700 } else { n % 100 };
            DecisionTiming { vetoes: u64::from(n == 42), ..timed(n, 1000 * n, plan_us, life, planner) }
        });
        let disturbance = |ms: u64, cause| {
            let from = MonotonicNs(1_000_000 * ms);
            Disturbance { from, until: from.plus_ns(1_000), cause }
        };
        // Whoever starts again at 600 asks for the map and loads the host; at 300 the host is busy by itself.
        let disturbances = vec![
            disturbance(600, Cause::HostLoad),
            disturbance(600, Cause::Snapshot),
            disturbance(300, Cause::HostLoad),
            disturbance(77, Cause::Restart(Role::Perception)),
        ];
        DecisionTimings::new(decisions, disturbances)
    }

    /// P-LATENCY-REPORT: The longest decisions of a latency report are named with their causes.
    #[test]
    fn the_worst_decisions_are_named_with_their_causes() {
        let report = timings().report(600_000, Conditions::default());
        assert_eq!((report.decisions, report.misses), (1000, 2));
        let worst: Vec<(u64, Vec<Cause>)> =
            report.worst.iter().take(2).map(|worst| (worst.decision.0, worst.causes.clone())).collect();
        assert_eq!(
            worst,
            [(0, vec![Cause::FirstPlan]), (600, vec![Cause::FirstPlan, Cause::PlannerRestart])]
        );
        assert!(report.worst.iter().all(|worst| worst.stage == Stage::Plan));
        assert_eq!(report.worst.len(), 10);
        assert_eq!(report.causes["swap"], (1, 0));
        assert_eq!(report.causes["first plan"], (3, 2));
        assert_eq!(report.causes["veto"], (1, 0));
        assert_eq!(report.causes["perception restart"], (1, 0));
        assert_eq!((report.causes["host load"], report.causes.get("snapshot")), ((1, 0), None));
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

    /// Compared with a search through all disturbances: long ones, short ones, and decisions whose
    /// clock began anew.
    #[test]
    fn every_happening_that_touches_a_decision_is_found() {
        let roles = Role::ALL;
        // A mixing of numbers, so that lengths and begins are in no order.
        let mixed = |n: u64, below: u64| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) % below;
        let disturbances: Vec<Disturbance> = (0..400)
            .map(|n| {
                let from = MonotonicNs(1_000 * mixed(n, 120_000));
                let length_us = if n % 50 == 0 { 30_000 } else { mixed(n + 7, 900) };
                let cause = Cause::Restart(roles[n as usize % roles.len()]);
                Disturbance { from, until: from.plus_ns(1_000 * length_us), cause }
            })
            .collect();
        let timeline = Timeline::new(disturbances.clone());
        let mut touched = 0;
        for n in 0..300_u64 {
            // From 200 on the clock has begun anew.
            let timed = timed(n, 500 * (n % 200), mixed(n, 700), 1, "mdp");
            let moments = (timed.timing.landed, timed.timing.committed);
            let all = disturbances.iter().filter(|one| one.from <= moments.1 && one.until >= moments.0);
            let mut need: Vec<Cause> = all.map(|disturbance| disturbance.cause).collect();
            need.sort_unstable();
            need.dedup();
            touched += need.len();
            assert_eq!(causes(&timed, Some(&timed), &timeline), need, "decision {n}");
        }
        assert!(touched > 300, "{touched}");
    }

    #[test]
    fn a_percentile_distribution_ends_with_all_decisions_at_the_maximum() {
        let text = timings().percentile_distribution();
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
        let timings = DecisionTimings::new(
            [DecisionTiming { timing: Timing::default(), ..timed(0, 0, 0, 1, "mdp") }],
            Vec::new(),
        );
        let report = timings.report(1, Conditions::default());
        assert_eq!((report.decisions, report.misses), (0, 0));
        assert!(report.to_string().contains("Nothing was measured"), "{report}");
        assert!(timings.percentile_distribution().contains("Total count"));
    }
}
