//! Formats numbers for reports.

use contract::Weights;

use crate::statistics::Sample;

/// Weights as the paper writes them; w3 only where it is not the paper's.
pub(crate) fn weights_in_brackets(weights: &Weights) -> String {
    let Weights { safety, information, distance } = weights;
    if *distance == 10.0 {
        format!("({safety}, {information})")
    } else {
        format!("({safety}, {information}, {distance})")
    }
}

pub(crate) fn percent(part: u64, whole: u64) -> String {
    if whole == 0 { "-".into() } else { format!("{:.1} %", 100.0 * part as f64 / whole as f64) }
}

pub(crate) fn number(value: Option<f64>, digits: usize) -> String {
    let text = value.map_or("-".into(), |value| format!("{value:.digits$}"));
    // A rounded zero is printed without its minus sign.
    match text.strip_prefix('-') {
        Some(size) if !size.is_empty() && size.chars().all(|c| matches!(c, '0' | '.')) => size.into(),
        _ => text,
    }
}

pub(crate) fn signed(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:+.1}"))
}

pub(crate) fn spread(sample: &Sample) -> String {
    match (sample.mean, sample.sd) {
        (Some(mean), Some(sd)) => format!("{mean:.1} ± {sd:.1}"),
        (Some(mean), None) => format!("{mean:.1}"),
        _ => "-".into(),
    }
}

/// Treasures as the paper writes them: number (episodes), the largest first.
pub(crate) fn treasures_collected(counts: impl DoubleEndedIterator<Item = (u64, u64)>) -> String {
    let parts: Vec<_> = counts.rev().map(|(number, episodes)| format!("{number} ({episodes})")).collect();
    if parts.is_empty() { "-".into() } else { parts.join(", ") }
}
