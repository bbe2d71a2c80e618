//! Where the time of every single decision went, as a table for programs.

use std::fmt::Write as _;

use contract::{Record, Stage};

/// The columns: what was executed, by whom, after how much work; from landing to command, and every stage on the
/// way, in microseconds. The columns of the stages sum to `total_us`.
#[must_use]
pub fn timetable_heading() -> String {
    let stages: Vec<String> = Stage::ALL.iter().map(|stage| format!("{stage}_us")).collect();
    let stages = stages.join(",");
    format!("decision,planner,action,work,cut,landing_to_command_us,feeding_us,{stages},total_us\n")
}

/// The line of one decision.
#[must_use]
pub fn timetable_row(record: &Record) -> String {
    let us = |ns: u64| ns as f64 / 1e3;
    let Record { decision, leader, action, work, cut, timing, .. } = record;
    let mut row = format!("{decision},{},{action},{work},{}", leader.planner, u8::from(*cut));
    for ns in [timing.answer_ns(), timing.feeding_ns()].into_iter().chain(timing.stages_ns()) {
        let _ = write!(row, ",{}", us(ns));
    }
    let _ = writeln!(row, ",{}", us(timing.total_ns()));
    row
}
