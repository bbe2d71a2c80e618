//! A number with an interval of 95 %, by the method that suits it.

use campaign::statistics::{Interval, Sample, welch, wilson};

/// A number with its interval.
#[derive(Clone, Copy)]
pub(crate) struct Range {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl From<Range> for (f64, f64) {
    fn from(Range { low, high, .. }: Range) -> Self {
        (low, high)
    }
}

impl Range {
    /// A share (Wilson).
    pub fn of_share(successes: u64, trials: u64) -> Self {
        let Interval { low, high } = wilson(successes, trials);
        Self { value: successes as f64 / trials as f64, low, high }
    }

    /// First mean less second (Welch).
    pub fn of_difference(first: &Sample, second: &Sample) -> Option<Self> {
        let critical = welch(first, second)?.critical;
        let value = first.mean? - second.mean?;
        let half = critical * (first.variance_of_mean()? + second.variance_of_mean()?).sqrt();
        Some(Self { value, low: value - half, high: value + half })
    }

    /// First share less second (Newcombe 1998, from the Wilson intervals of both).
    pub fn of_shares(first: (u64, u64), second: (u64, u64)) -> Self {
        let [a, b] = [first, second].map(|(successes, trials)| Self::of_share(successes, trials));
        let value = a.value - b.value;
        let low = value - libm::hypot(a.value - a.low, b.high - b.value);
        let high = value + libm::hypot(a.high - a.value, b.value - b.low);
        Self { value, low, high }
    }

    /// How many times the second share the first is, by its logarithm (Katz et al. 1978); `None` if one is 0.
    pub fn of_ratio((a, in_a): (u64, u64), (b, in_b): (u64, u64)) -> Option<Self> {
        if a == 0 || b == 0 {
            return None;
        }
        let [a, in_a, b, in_b] = [a, in_a, b, in_b].map(|count| count as f64);
        let value = (a / in_a) / (b / in_b);
        let error = (1.0 / a - 1.0 / in_a + 1.0 / b - 1.0 / in_b).sqrt();
        let factor = libm::exp(1.96 * error);
        Some(Self { value, low: value / factor, high: value * factor })
    }

    /// In words, with so many decimals.
    pub fn written(&self, decimals: usize) -> String {
        let Self { value, low, high } = self;
        let text = format!("{value:.decimals$} ({low:.decimals$} to {high:.decimals$})");
        text.replace('-', "−")
    }

    /// In words, as per cent.
    pub fn percent(&self) -> String {
        let scale = |part: f64| 100.0 * part;
        Self { value: scale(self.value), low: scale(self.low), high: scale(self.high) }.written(1)
    }
}
