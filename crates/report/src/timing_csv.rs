//! The timing of every decision as CSV.

use std::fmt::Write as _;

use contract::{Record, Stage};

/// The stages of a record that its journal has: all but the last. A record is written before its commit is over, so that its
/// [`contract::Timing::committed`] is the moment at which the append was requested.
const STAGES: usize = Stage::Commit as usize;

/// The heading line: decision, planner, action, work, then the time from landing to command and every stage until then in
/// microseconds, and the robot whose decision it is. The stages add up to the time from landing to command.
#[must_use]
pub fn timing_csv_heading() -> String {
    let stages: Vec<String> = Stage::ALL[..STAGES].iter().map(|stage| format!("{stage}_us")).collect();
    let stages = stages.join(",");
    format!("decision,planner,action,work,cut,landing_to_command_us,feeding_us,{stages},robot\n")
}

/// The line of one decision, with its line break.
#[must_use]
pub fn timing_csv_row(record: &Record) -> String {
    let us = |ns: u64| ns as f64 / 1e3;
    let Record { robot, decision, leader, action, work, cut, timing, .. } = record;
    let mut row = format!("{decision},{},{action},{work},{}", leader.planner, u8::from(*cut));
    for ns in [timing.answer_ns(), timing.feeding_ns()].iter().chain(&timing.stages_ns()[..STAGES]) {
        let _ = write!(row, ",{}", us(*ns));
    }
    let _ = writeln!(row, ",{robot}");
    row
}
