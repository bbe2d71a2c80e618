//! The timing of every decision as CSV.

use std::fmt::Write as _;

use contract::{Record, Stage};

/// The heading line: decision, planner, action, work, then the time from landing to command and every stage in
/// microseconds. The columns of the stages sum to `total_us`.
#[must_use]
pub fn timing_csv_heading() -> String {
    let stages: Vec<String> = Stage::ALL.iter().map(|stage| format!("{stage}_us")).collect();
    let stages = stages.join(",");
    format!("decision,planner,action,work,cut,landing_to_command_us,feeding_us,{stages},total_us\n")
}

/// The line of one decision, with its line break.
#[must_use]
pub fn timing_csv_row(record: &Record) -> String {
    let us = |ns: u64| ns as f64 / 1e3;
    let Record { decision, leader, action, work, cut, timing, .. } = record;
    let mut row = format!("{decision},{},{action},{work},{}", leader.planner, u8::from(*cut));
    for ns in [timing.answer_ns(), timing.feeding_ns()].into_iter().chain(timing.stages_ns()) {
        let _ = write!(row, ",{}", us(ns));
    }
    let _ = writeln!(row, ",{}", us(timing.total_ns()));
    row
}
