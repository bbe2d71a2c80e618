//! Histograms of durations.

use hdrhistogram::Histogram;

/// Longest duration that histograms distinguish, nanoseconds: a day. Longer ones count as a day.
const DURATION_MAX_NS: u64 = 86_400_000_000_000;

/// An empty histogram that grows as needed, with three significant digits.
pub(crate) fn empty() -> Histogram<u64> {
    Histogram::new(3).expect("three digits are within 0 to 5")
}

/// Adds a duration, nanoseconds.
pub(crate) fn record(histogram: &mut Histogram<u64>, ns: u64) {
    histogram
        .record(ns.min(DURATION_MAX_NS))
        .expect("the histogram grows to a day, which any address space holds");
}

/// The histogram of `durations_ns`.
pub(crate) fn histogram(durations_ns: impl Iterator<Item = u64>) -> Histogram<u64> {
    let mut histogram = empty();
    durations_ns.for_each(|ns| record(&mut histogram, ns));
    histogram
}

/// Microseconds, exact to the nanosecond.
pub(crate) fn us(ns: u64) -> f64 {
    ns as f64 / 1e3
}
