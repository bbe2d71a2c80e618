//! The timing of every decision as CSV.

use std::fmt::Write as _;

use contract::{Record, Stage};

/// The stages of a record that its journal has: all but the last. A record is written before its commit is over, so that its
/// [`contract::Timing::committed`] is the moment at which the append was requested.
const STAGES: usize = Stage::Commit as usize;

/// The heading line: decision, planner, action, work, then the time from landing to command and every stage until then in
/// microseconds, their sum, and the robot whose decision it is.
#[must_use]
pub fn timing_csv_heading() -> String {
    let stages: Vec<String> = Stage::ALL[..STAGES].iter().map(|stage| format!("{stage}_us")).collect();
    let stages = stages.join(",");
    format!("decision,planner,action,work,cut,landing_to_command_us,feeding_us,{stages},total_us,robot\n")
}

/// The line of one decision, with its line break.
#[must_use]
pub fn timing_csv_row(record: &Record) -> String {
    let us = |ns: u64| ns as f64 / 1e3;
    let Record { robot, decision, leader, action, work, cut, timing, .. } = record;
    let mut row = format!("{decision},{},{action},{work},{}", leader.planner, u8::from(*cut));
    let stages_ns = timing.stages_ns();
    let stages_ns = &stages_ns[..STAGES];
    for ns in [timing.answer_ns(), timing.feeding_ns()].iter().chain(stages_ns) {
        let _ = write!(row, ",{}", us(*ns));
    }
    let _ = writeln!(row, ",{},{robot}", us(stages_ns.iter().sum()));
    row
}
