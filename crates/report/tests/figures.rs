//! Every figure that a user gets of the timing of decisions, from a mission in which no two moments have the same distance.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod mission;

use contract::{
    Account, Action, Branch, Direction, MonotonicNs, Record, RefusalCounts, RobotId, Stage, Timing,
};
use hdrhistogram::Histogram;
use mission::{Step, brief, helicopter, records, with_robots};
use report::{
    Conditions, DecisionTiming, DecisionTimings, Executed, Percentiles, SummaryBuilder, Tally,
    timing_csv_heading, timing_csv_row,
};

const BUDGET_NS: u64 = 9_000_000;

/// How long a stage of a decision takes, nanoseconds: all different, and each stage of another magnitude.
fn length_ns(decision: u64, stage: usize) -> u64 {
    let magnitudes = [1_300, 17_000, 23_000, 290_000, 3_100_000, 41_000, 530_000];
    magnitudes[stage] + decision * (stage as u64 + 7) * 101 + decision % 5 * magnitudes[stage] / 3
}

/// 997 decisions of three robots, one after the other, with a reboot after the 400th.
fn flown() -> (contract::Brief, Vec<Record>) {
    let mut brief = brief(40);
    brief.limits.decision_budget_ns = BUDGET_NS;
    let step: Step = (Action::Hop(Direction::North), Branch::Stayed);
    let mut records = records(&brief, &[step; 997], 500);
    let robots = [brief.robots[0], helicopter(&brief), helicopter(&brief)];
    let brief = with_robots(&brief, Account::Hopper, &robots);
    let mut clock_ns = 77_000_000_000;
    for (decision, record) in (0..).zip(&mut records) {
        record.robot = RobotId((decision % 3) as u16);
        if decision == 400 {
            clock_ns = 5_000_000_000;
        }
        let mut moments = [MonotonicNs(clock_ns); 8];
        for stage in 0..7 {
            moments[stage + 1] = moments[stage].plus_ns(length_ns(decision, stage));
        }
        record.timing = Timing::from_moments(moments);
        clock_ns = moments[7].0 + 2_000_017;
    }
    (brief, records)
}

fn lengths(stages: std::ops::Range<usize>) -> Vec<u64> {
    (0..997).map(|decision| stages.clone().map(|stage| length_ns(decision, stage)).sum()).collect()
}

/// Percentiles beside `hdrhistogram` to the microsecond, with its three digits; maximum and mean to the nanosecond.
fn assert_percentiles(what: &str, spent_ns: &[u64], got: &Percentiles) {
    let mut histogram = Histogram::<u64>::new(3).unwrap();
    spent_ns.iter().for_each(|ns| histogram.record(*ns).unwrap());
    let max_ns = *spent_ns.iter().max().unwrap();
    for (share, got_us) in [(0.5, got.p50_us), (0.9, got.p90_us), (0.99, got.p99_us)] {
        let need_us = histogram.value_at_quantile(share).min(max_ns) as f64 / 1e3;
        assert!((need_us - got_us).abs() < 1.0, "{what} at {share}: {got_us} us, needs {need_us} us");
    }
    assert_eq!(got.max_us, max_ns as f64 / 1e3, "{what}");
    let mean_us = spent_ns.iter().sum::<u64>() as f64 / spent_ns.len() as f64 / 1e3;
    assert!(
        (got.mean_us - mean_us).abs() < 0.001,
        "{what}: {} us in the mean, needs {mean_us} us",
        got.mean_us
    );
}

/// P-STAMPS-FIGURES: Percentiles of summary and latency report agree with `hdrhistogram` to the
/// microsecond; misses, columns and robots agree with a mission of known stages; and a reboot
/// neither loses nor adds time.
#[test]
fn every_latency_of_the_summary_is_that_of_its_stages() {
    let (brief, records) = flown();
    let mut builder = SummaryBuilder::new(&brief, 7);
    records.iter().for_each(|record| builder.record(record));
    let end = records.last().unwrap().state_after(brief.run, MonotonicNs(1), MonotonicNs(2));
    let summary = builder.build(&end, None, &RefusalCounts::default());
    let latency = &summary.latency;
    for (number, stage) in Stage::ALL.into_iter().enumerate() {
        assert_percentiles(stage.as_str(), &lengths(number..number + 1), &latency.stages[&stage]);
    }
    assert_percentiles("total", &lengths(0..7), &latency.total);
    assert_percentiles("answer", &lengths(0..6), &latency.answer);
    assert_percentiles("feeding", &lengths(1..4), &latency.feeding);
    assert_eq!((latency.decisions, latency.budget_us), (997, BUDGET_NS as f64 / 1e3));
    let over = |spent: &[u64]| spent.iter().filter(|ns| **ns > BUDGET_NS).count() as u64;
    assert_eq!(latency.misses, over(&lengths(0..7)));
    let mut before = 0;
    let mut per_step = Vec::new();
    for (record, total_ns) in records.iter().zip(lengths(0..7)) {
        per_step.push(total_ns / (record.steps - before));
        before = record.steps;
    }
    assert_percentiles("per step", &per_step, &latency.per_step.percentiles);
    assert_eq!(latency.per_step.misses, over(&per_step));
    // No time passes between two boots, and none is lost.
    let boot_ns = |decisions: &[Record]| {
        decisions[decisions.len() - 1].timing.committed.0 - decisions[0].timing.landed.0
    };
    let need_s = (boot_ns(&records[..400]) + boot_ns(&records[400..])) as f64 / 1e9;
    assert_eq!(summary.duration_s, need_s);
    assert!(need_s > 3.0 && summary.to_string().contains(&format!("{need_s:.2} s from first landing")));
    let mut states = Tally::new(&brief);
    for record in &records {
        let state = record.state_after(brief.run, MonotonicNs(1), MonotonicNs(2));
        states.fold(&Executed::before(&state).unwrap());
    }
    assert_eq!((&states.latency.report(), states.duration_s), (latency, need_s));
}

/// P-STAMPS-FIGURES. For `timing.csv`.
#[test]
fn every_column_of_timing_csv_is_that_of_its_stage_and_robot() {
    let (_, records) = flown();
    let heading = timing_csv_heading();
    assert_eq!(
        heading.trim_end(),
        "decision,planner,action,work,cut,landing_to_command_us,feeding_us,state_us,sense_us,map_us,deliver_us,plan_us,\
         command_us,robot"
    );
    for (decision, record) in (0..).zip(&records) {
        let us = |stages: std::ops::Range<usize>| {
            stages.map(|stage| length_ns(decision, stage)).sum::<u64>() as f64 / 1e3
        };
        let mut need = vec![us(0..6), us(1..4)];
        need.extend((0..6).map(|stage| us(stage..stage + 1)));
        let row = timing_csv_row(record);
        let cells: Vec<&str> = row.trim_end().split(',').collect();
        let got: Vec<f64> = cells[5..13].iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(got, need, "{row}");
        assert_eq!(
            (cells[0], cells[1], cells[13]),
            (
                decision.to_string().as_str(),
                record.leader.planner.as_str(),
                (decision % 3).to_string().as_str()
            )
        );
    }
}

/// P-STAMPS-FIGURES. For the latency report, exact to the nanosecond.
#[test]
fn every_time_of_the_latency_report_is_that_of_its_stages() {
    let (_, records) = flown();
    let account = DecisionTimings::new(records.iter().map(DecisionTiming::from), Vec::new());
    let report = account.report(BUDGET_NS, Conditions::default());
    let exact = |what: &str, mut spent: Vec<u64>, got: &report::decisions::StageTimes| {
        spent.sort_unstable();
        // 997 decisions: the 499th, 898th, 988th and 997th.
        let need = [498, 897, 987, 996, 996].map(|index| spent[index] as f64 / 1e3);
        assert_eq!([got.p50_us, got.p90_us, got.p99_us, got.p99_9_us, got.max_us], need, "{what}");
        let mean_us = spent.iter().sum::<u64>() as f64 / 997.0 / 1e3;
        assert!((got.mean_us - mean_us).abs() < 1e-6, "{what}");
    };
    for (number, stage) in Stage::ALL.into_iter().enumerate() {
        exact(stage.as_str(), lengths(number..number + 1), &report.stages[&stage]);
    }
    exact("total", lengths(0..7), &report.total);
    exact("answer", lengths(0..6), &report.answer);
    let mdp = &report.groups[0];
    assert_eq!((mdp.planner.as_str(), mdp.decisions), ("mdp", 500));
    assert_eq!(mdp.total.max_us, *lengths(0..7)[..500].iter().max().unwrap() as f64 / 1e3);
    let totals = lengths(0..7);
    let mut longest: Vec<usize> = (0..997).collect();
    longest.sort_by_key(|decision| std::cmp::Reverse(totals[*decision]));
    for (worst, decision) in report.worst.iter().zip(longest) {
        assert_eq!((worst.decision.0, worst.total_us), (decision as u64, totals[decision] as f64 / 1e3));
        assert_eq!((worst.stage, worst.stage_us), (Stage::Plan, length_ns(decision as u64, 4) as f64 / 1e3));
    }
    let flown_s = report.decisions as f64 / report.conditions.hops_per_second.unwrap();
    assert!(flown_s > 3.0 && flown_s < 60.0, "a reboot neither stops nor stretches time: {flown_s} s");
}
