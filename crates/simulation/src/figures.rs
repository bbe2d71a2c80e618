//! Figures over the decisions of a mission, computed the slow way and compared with those that users get.

use contract::{Brief, Record, RefusalCounts, Stage, Timing};
use report::{
    Conditions, DecisionTiming, DecisionTimings, Percentiles, SummaryBuilder, Tally, timing_csv_heading,
    timing_csv_row,
};

use crate::stamps::Landing;

/// Checks summary, `timing.csv` and latency report of a mission that left `records` in its journal.
///
/// # Errors
/// What is wrong, if a figure is.
pub(crate) fn check(brief: &Brief, records: &[Record]) -> Result<(), String> {
    let Some(last) = records.last() else { return Ok(()) };
    let timings: Vec<Timing> = records.iter().map(|record| record.timing).collect();
    let mut summary = SummaryBuilder::new(brief, 0);
    records.iter().for_each(|record| summary.record(record));
    let end = last.state_after(brief.run, last.timing.committed, last.timing.committed);
    let summary = summary.build(&end, None, &RefusalCounts::default());
    let latency = &summary.latency;
    let measured: Vec<&Timing> = timings.iter().filter(|timing| timing.committed.0 > 0).collect();
    equal("decisions measured", measured.len() as u64, latency.decisions)?;
    let spent = |what: &dyn Fn(&Timing) -> u64| measured.iter().map(|timing| what(timing)).collect();
    percentiles("total", spent(&total_ns), &latency.total)?;
    percentiles("answer", spent(&|timing| until(timing, 6)), &latency.answer)?;
    percentiles("feeding", spent(&|timing| until(timing, 4) - until(timing, 1)), &latency.feeding)?;
    for (number, stage) in Stage::ALL.into_iter().enumerate() {
        percentiles(stage.as_str(), spent(&|timing| stage_ns(timing, number)), &latency.stages[&stage])?;
    }
    let budget_ns = brief.limits.decision_budget_ns;
    let misses = measured.iter().filter(|timing| total_ns(timing) > budget_ns).count() as u64;
    equal("misses", misses, latency.misses)?;
    let mut steps_before = 0;
    let mut per_step = Vec::new();
    for record in records {
        let steps = record.steps.saturating_sub(steps_before).max(1);
        steps_before = record.steps;
        if record.timing.committed.0 > 0 {
            per_step.push(total_ns(&record.timing) / steps);
        }
    }
    equal(
        "misses per step",
        per_step.iter().filter(|ns| **ns > budget_ns).count() as u64,
        latency.per_step.misses,
    )?;
    percentiles("per step", per_step, &latency.per_step.percentiles)?;
    close("duration", duration_ns(&timings) as f64 / 1e9, summary.duration_s)?;
    rows(records)?;
    report(brief, records, &measured)
}

/// Checks what a monitor holds of the decisions that led to `landings`. Which moment of a commit it knows depends on how it
/// came by a decision, so that only what lies before is compared.
///
/// # Errors
/// What is wrong, if a figure is.
pub(crate) fn check_tally(tally: &Tally, landings: &[Landing]) -> Result<(), String> {
    let Some(last) = landings.last() else { return Ok(()) };
    if let Some(executed) = tally.last
        && !last.timings().any(|timing| timing == executed.timing)
    {
        return Err(format!(
            "the monitor times decision {} as {:?}, it was {last:?}",
            executed.decision, executed.timing
        ));
    }
    let latency = tally.latency.report();
    // Nobody measures time on a journal that was flown on elsewhere.
    let measured: Vec<Timing> =
        landings.iter().map(|landing| landing.journalled).filter(|timing| timing.committed.0 > 0).collect();
    equal("decisions that the monitor measured", measured.len() as u64, latency.decisions)?;
    let spent = |what: &dyn Fn(&Timing) -> u64| measured.iter().map(what).collect();
    percentiles("the monitor's answer", spent(&|timing| until(timing, 6)), &latency.answer)?;
    for (number, stage) in Stage::ALL.into_iter().enumerate().take(Stage::Commit as usize) {
        percentiles(stage.as_str(), spent(&|timing| stage_ns(timing, number)), &latency.stages[&stage])?;
    }
    Ok(())
}

/// Checks a row of the page: the landing before the decision in milliseconds, its robot, how long the action lasted in seconds of
/// simulated time, and its stages in microseconds.
///
/// # Errors
/// What is wrong, if a figure is.
pub(crate) fn check_row(row: &[f64], landing: &Landing) -> Result<(), String> {
    let Some(lasts_s) = row.get(2).copied().filter(|lasts_s| *lasts_s >= 0.0) else {
        return Err(format!("the page shows {row:?}, with no length of the action"));
    };
    let is_of = |timing: &Timing| {
        let mut need = vec![(timing.landed.0 as f64 / 1e6).round(), f64::from(landing.robot.0), lasts_s];
        need.extend((0..Stage::ALL.len()).map(|stage| stage_ns(timing, stage) as f64 / 1e3));
        need.len() == row.len() && need.iter().zip(row).all(|(need, got)| (need - got).abs() <= 0.0501)
    };
    if landing.timings().any(|timing| is_of(&timing)) {
        return Ok(());
    }
    Err(format!("the page shows {row:?} of {landing:?}"))
}

/// Landed until the end of the `stages` first stages, nanoseconds. What reads earlier than what went before counts as
/// simultaneous with it, and nothing ends after the commit.
fn until(timing: &Timing, stages: usize) -> u64 {
    let moments = timing.moments();
    let from = moments[0].0;
    let end = timing.committed.0.max(from);
    let latest = moments[..=stages].iter().map(|moment| moment.0).max().unwrap_or(from);
    latest.min(end) - from
}

fn stage_ns(timing: &Timing, stage: usize) -> u64 {
    let before = if stage == 0 { 0 } else { until(timing, stage) };
    let after = if stage + 1 == Stage::ALL.len() { total_ns(timing) } else { until(timing, stage + 1) };
    after - before
}

fn total_ns(timing: &Timing) -> u64 {
    timing.committed.0.saturating_sub(timing.landed.0)
}

/// From the first landing to the last commit; a clock that began anew in between counts the time before and after.
fn duration_ns(timings: &[Timing]) -> u64 {
    let runs = timings.chunk_by(|before, after| after.landed >= before.committed);
    runs.map(|run| run[run.len() - 1].committed.since_ns(run[0].landed)).sum()
}

fn equal<T: PartialEq + std::fmt::Debug>(what: &str, need: T, got: T) -> Result<(), String> {
    if need == got { Ok(()) } else { Err(format!("{what} is {got:?}, needs {need:?}")) }
}

fn close(what: &str, need: f64, got: f64) -> Result<(), String> {
    let is_close = (need - got).abs() <= 1e-9 * need.abs().max(1.0);
    if is_close { Ok(()) } else { Err(format!("{what} is {got}, needs {need}")) }
}

/// Nearest ranks to three digits, maximum and mean to the nanosecond.
fn percentiles(what: &str, mut spent: Vec<u64>, got: &Percentiles) -> Result<(), String> {
    spent.sort_unstable();
    let Some(most) = spent.last().copied() else { return equal(what, Percentiles::default(), *got) };
    for (share, got_us) in [(0.5, got.p50_us), (0.9, got.p90_us), (0.99, got.p99_us)] {
        let rank = (share * spent.len() as f64).ceil() as usize;
        let need_us = spent[rank.max(1) - 1] as f64 / 1e3;
        if (need_us - got_us).abs() > 0.001 * need_us + 0.001 {
            return Err(format!("{what} at {share} is {got_us} us, needs {need_us} us"));
        }
    }
    close(&format!("{what} at most"), most as f64 / 1e3, got.max_us)?;
    let mean_us = spent.iter().map(|ns| *ns as f64).sum::<f64>() / spent.len() as f64 / 1e3;
    if (mean_us - got.mean_us).abs() > 1e-6 * mean_us + 0.001 {
        return Err(format!("{what} is {} us in the mean, needs {mean_us} us", got.mean_us));
    }
    Ok(())
}

/// Rows of `timing.csv`, by the names of its columns.
fn rows(records: &[Record]) -> Result<(), String> {
    let heading = timing_csv_heading();
    for record in records {
        let row = timing_csv_row(record);
        let cells: Vec<&str> = row.trim_end().split(',').collect();
        let names: Vec<&str> = heading.trim_end().split(',').collect();
        equal("columns", names.len(), cells.len())?;
        let timing = &record.timing;
        let mut need: Vec<(String, f64)> = vec![
            ("decision".into(), record.decision.0 as f64),
            ("robot".into(), f64::from(record.robot.0)),
            ("landing_to_command_us".into(), until(timing, 6) as f64 / 1e3),
            ("feeding_us".into(), (until(timing, 4) - until(timing, 1)) as f64 / 1e3),
        ];
        let stages = Stage::ALL.into_iter().enumerate().take(Stage::Commit as usize);
        need.extend(stages.map(|(n, stage)| (format!("{stage}_us"), stage_ns(timing, n) as f64 / 1e3)));
        for (name, need) in need {
            let column = names.iter().position(|known| *known == name);
            let got = column.and_then(|column| cells[column].parse::<f64>().ok());
            equal(&format!("{name} of decision {}", record.decision), Some(need), got)?;
        }
    }
    Ok(())
}

/// The latency report.
fn report(brief: &Brief, records: &[Record], measured: &[&Timing]) -> Result<(), String> {
    let account = DecisionTimings::new(records.iter().map(DecisionTiming::from), Vec::new());
    let report = account.report(brief.limits.decision_budget_ns, Conditions::default());
    let most = |what: &dyn Fn(&Timing) -> u64| {
        measured.iter().map(|timing| what(timing)).max().unwrap_or_default() as f64 / 1e3
    };
    // Its maxima have three digits.
    let near = |what: &str, need: f64, got: f64| {
        if (need - got).abs() <= 0.001 * need {
            Ok(())
        } else {
            Err(format!("reported {what} is {got}, needs {need}"))
        }
    };
    near("total", most(&total_ns), report.total.max_us)?;
    near("answer", most(&|timing| until(timing, 6)), report.answer.max_us)?;
    for (number, stage) in Stage::ALL.into_iter().enumerate() {
        near(stage.as_str(), most(&|timing| stage_ns(timing, number)), report.stages[&stage].max_us)?;
    }
    let Some(worst) = report.worst.first() else { return Ok(()) };
    let record = &records[worst.decision.0 as usize];
    equal("the longest decision", most(&total_ns), worst.total_us)?;
    equal("its time", total_ns(&record.timing) as f64 / 1e3, worst.total_us)?;
    equal("its stage", stage_ns(&record.timing, worst.stage as usize) as f64 / 1e3, worst.stage_us)?;
    equal("its planner", (record.leader.planner, record.leader.term), (worst.planner, worst.term))
}
