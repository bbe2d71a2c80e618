//! Formats numbers for reports.

use contract::Weights;

use crate::statistics::Sample;
use crate::tally::CellStatistics;

/// Weights in brackets: (w1, w2); w3 too where it is not 10, as in most scenarios.
#[must_use]
pub fn weights_in_brackets(weights: &Weights) -> String {
    let Weights { safety, information, distance } = weights;
    if *distance == 10.0 {
        format!("({safety}, {information})")
    } else {
        format!("({safety}, {information}, {distance})")
    }
}

/// A share in percent; a dash of nothing.
#[must_use]
pub fn percent(part: u64, whole: u64) -> String {
    if whole == 0 { "-".into() } else { format!("{:.1} %", 100.0 * part as f64 / whole as f64) }
}

/// A number with so many digits after the point; a dash if there is none.
#[must_use]
pub fn number(value: Option<f64>, digits: usize) -> String {
    let text = value.map_or("-".into(), |value| format!("{value:.digits$}"));
    // A rounded zero is printed without its minus sign.
    match text.strip_prefix('-') {
        Some(size) if !size.is_empty() && size.chars().all(|c| matches!(c, '0' | '.')) => size.into(),
        _ => text,
    }
}

/// A number with its sign and one digit after the point; a dash if there is none.
#[must_use]
pub fn signed(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:+.1}"))
}

/// Mean ± standard deviation, as far as the sample has them.
#[must_use]
pub fn spread(sample: &Sample) -> String {
    match (sample.mean, sample.sd) {
        (Some(mean), Some(sd)) => format!("{mean:.1} ± {sd:.1}"),
        (Some(mean), None) => format!("{mean:.1}"),
        _ => "-".into(),
    }
}

/// Treasures collected: number (episodes), the largest number first.
#[must_use]
pub fn treasures_collected(counts: impl DoubleEndedIterator<Item = (u64, u64)>) -> String {
    let parts: Vec<_> = counts.rev().map(|(number, episodes)| format!("{number} ({episodes})")).collect();
    if parts.is_empty() { "-".into() } else { parts.join(", ") }
}

/// Treasures collected by the successes of a cell; a dash if none collected any.
#[must_use]
pub fn treasures_of(statistics: &CellStatistics) -> String {
    if statistics.treasure_counts.keys().all(|number| *number == 0) {
        return "-".into();
    }
    treasures_collected(statistics.treasure_counts.iter().map(|(number, episodes)| (*number, *episodes)))
}
