//! Where the time of every single decision went, as a table for programs.

use std::fmt::Write as _;

use contract::{Record, Stage};

/// One line a decision: what was commanded, by whom, after how much work; from landing to command, and every
/// stage on the way, in microseconds. The columns of the stages sum to `total_us`.
#[must_use]
pub fn timetable<'a>(records: impl IntoIterator<Item = &'a Record>) -> String {
    let stages: Vec<String> = Stage::ALL.iter().map(|stage| format!("{stage}_us")).collect();
    let mut text = format!(
        "decision,planner,action,work,cut,landing_to_command_us,feeding_us,{},total_us\n",
        stages.join(",")
    );
    let us = |ns: u64| ns as f64 / 1e3;
    for record in records {
        let Record { decision, leader, action, work, cut, timing, .. } = record;
        let _ = write!(text, "{decision},{},{action},{work},{}", leader.planner, u8::from(*cut));
        for ns in [timing.answer_ns(), timing.feeding_ns()].into_iter().chain(timing.stages_ns()) {
            let _ = write!(text, ",{}", us(ns));
        }
        let _ = writeln!(text, ",{}", us(timing.total_ns()));
    }
    text
}
