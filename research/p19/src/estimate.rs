//! Means, and functions of two means or deviations, each with its 95 % interval.

use serde::Serialize;

/// Half the width of a 95 % interval in standard errors: the normal quantile, for samples of at least 100.
const Z: f64 = 1.959_964;

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The best value.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl From<&Estimate> for (f64, f64) {
    /// The interval.
    fn from(Estimate { low, high, .. }: &Estimate) -> Self {
        (*low, *high)
    }
}

impl Estimate {
    fn new(value: f64, error: f64) -> Self {
        Self { value, low: value - Z * error, high: value + Z * error }
    }

    /// The mean of `values`.
    pub fn mean(values: impl Iterator<Item = f64> + Clone) -> Self {
        let Moments { count, sum: [sum, _], squares: [squares, _] } =
            Moments::of(values.map(|value| [value, 0.0]));
        let variance = ((squares - sum * sum / count) / (count - 1.0)).max(0.0);
        Self::new(sum / count, (variance / count).sqrt())
    }

    /// What `statistic` gives of pairs of measurements, by the jackknife: its spread over all samples that lack one pair
    /// (Efron & Stein 1981).
    pub fn jackknife(pairs: &[[f64; 2]], statistic: impl Fn(&Moments) -> f64) -> Self {
        let all = Moments::of(pairs.iter().copied());
        let value = statistic(&all);
        let squares: f64 = pairs.iter().map(|pair| (statistic(&all.without(*pair)) - value).powi(2)).sum();
        Self::new(value, ((all.count - 1.0) / all.count * squares).sqrt())
    }

    /// In another unit.
    pub fn times(&self, factor: f64) -> Self {
        Self { value: factor * self.value, low: factor * self.low, high: factor * self.high }
    }

    /// The value and its interval with so many decimals.
    pub fn written(&self, decimals: usize) -> String {
        let Self { value, low, high } = self;
        format!("{value:.decimals$} ({low:.decimals$} to {high:.decimals$})")
    }
}

/// Sums over pairs of measurements.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    count: f64,
    sum: [f64; 2],
    squares: [f64; 2],
}

impl Moments {
    /// The sums of `pairs`.
    pub fn of(pairs: impl Iterator<Item = [f64; 2]>) -> Self {
        let none = Self { count: 0.0, sum: [0.0; 2], squares: [0.0; 2] };
        pairs.fold(none, |moments, pair| moments.plus(pair, 1.0))
    }

    fn without(&self, pair: [f64; 2]) -> Self {
        self.plus(pair, -1.0)
    }

    fn plus(&self, pair: [f64; 2], times: f64) -> Self {
        Self {
            count: self.count + times,
            sum: std::array::from_fn(|n| self.sum[n] + times * pair[n]),
            squares: std::array::from_fn(|n| self.squares[n] + times * pair[n] * pair[n]),
        }
    }

    /// Second mean over the first.
    pub fn ratio_of_means(&self) -> f64 {
        self.sum[1] / self.sum[0]
    }

    /// Second standard deviation over the first.
    pub fn ratio_of_deviations(&self) -> f64 {
        let [first, second] = self.variances();
        (second / first).sqrt()
    }

    /// Standard deviations with n − 1.
    pub fn deviations(&self) -> [f64; 2] {
        self.variances().map(f64::sqrt)
    }

    fn variances(&self) -> [f64; 2] {
        let variance = |n: usize| (self.squares[n] - self.sum[n].powi(2) / self.count) / (self.count - 1.0);
        std::array::from_fn(|n| variance(n).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_mean_is_the_textbook_one() {
        let Estimate { value, low, high } = Estimate::mean([1.0, 2.0, 3.0, 4.0].into_iter());
        // Standard deviation √(5/3), standard error √(5/12).
        let half = 1.959_964 * (5.0_f64 / 12.0).sqrt();
        assert!(
            (value - 2.5).abs() < 1e-12
                && (high - value - half).abs() < 1e-12
                && (value - low - half).abs() < 1e-12
        );
    }

    /// The jackknife of a mean is its standard error, to the bit of rounding.
    #[test]
    fn the_jackknife_of_a_mean_is_that_of_the_textbook() {
        let pairs: Vec<[f64; 2]> = (0..50).map(|n| [1.0, f64::from(n * n % 17)]).collect();
        let jackknife = Estimate::jackknife(&pairs, Moments::ratio_of_means);
        let mean = Estimate::mean(pairs.iter().map(|pair| pair[1]));
        assert!((jackknife.low - mean.low).abs() < 1e-9 && (jackknife.high - mean.high).abs() < 1e-9);
    }
}
