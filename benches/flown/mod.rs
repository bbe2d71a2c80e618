//! What a flown mission's journal says of its time.

use std::path::Path;

use contract::Timing;
use hopper_sim::JournalReader;

/// Moments of every decision but the first, which waits for processes to start and says nothing of the pipeline.
pub fn timings(journal: &Path) -> Vec<Timing> {
    let history = JournalReader::open(journal).expect("a journal");
    history.records().skip(1).map(|record| record.expect("a sound record").timing).collect()
}

/// Landing to command accepted, less planning, microseconds.
pub fn overhead_us(timing: &Timing) -> f64 {
    let reaction_ns = timing.accepted.since_ns(timing.landed);
    let planning_ns = timing.planning_ended.since_ns(timing.planning_started);
    (reaction_ns - planning_ns) as f64 / 1e3
}

/// Median, the upper one of two.
///
/// # Panics
/// If there are no values.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    assert!(!values.is_empty(), "a median needs values");
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
