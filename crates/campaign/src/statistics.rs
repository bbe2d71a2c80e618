//! Wilson's interval, t-tests, Fisher's exact test, differences in standard errors.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, DiscreteCDF, Hypergeometric, Normal, StudentsT};

/// Count, mean and sample standard deviation of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// Values added so far, n.
    pub count: u64,
    /// Mean; `None` without values.
    pub mean: Option<f64>,
    /// Standard deviation with n − 1; `None` for fewer than two values.
    pub sd: Option<f64>,
}

impl Sample {
    /// A sample known only by its published count, mean and standard deviation.
    #[must_use]
    pub fn published(count: u64, mean: f64, sd: f64) -> Self {
        Self { count, mean: Some(mean), sd: Some(sd) }
    }

    /// The sample of values with the number of times each occurs.
    #[must_use]
    pub fn of(values: impl Iterator<Item = (u64, u64)> + Clone) -> Self {
        let count: u64 = values.clone().map(|(_, n)| n).sum();
        if count == 0 {
            return Self { count, mean: None, sd: None };
        }
        let sum: u64 = values.clone().map(|(value, n)| value * n).sum();
        let mean = sum as f64 / count as f64;
        let squares: f64 = values.map(|(value, n)| n as f64 * (value as f64 - mean).powi(2)).sum();
        let sd = (count > 1).then(|| (squares / (count - 1) as f64).sqrt());
        Self { count, mean: Some(mean), sd }
    }

    /// Squared standard error of the mean.
    #[must_use]
    pub fn variance_of_mean(&self) -> Option<f64> {
        Some(self.sd?.powi(2) / self.count as f64)
    }
}

/// A closed interval of shares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end, 0 to 1.
    pub low: f64,
    /// Upper end, 0 to 1.
    pub high: f64,
}

/// Wilson's 95 % score interval of `successes` out of `count` (Wilson 1927); 0 to 1 if `count` is 0.
#[must_use]
pub fn wilson(successes: u64, count: u64) -> Interval {
    if count == 0 {
        return Interval { low: 0.0, high: 1.0 };
    }
    let z = Normal::standard().inverse_cdf(0.975);
    let (n, p) = (count as f64, successes as f64 / count as f64);
    let scale = 1.0 + z * z / n;
    let centre = (p + z * z / (2.0 * n)) / scale;
    let half = z / scale * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    // Exact at the ends, where rounding would leave 1e-17.
    let low = if successes == 0 { 0.0 } else { centre - half };
    let high = if successes == count { 1.0 } else { centre + half };
    Interval { low, high }
}

/// Welch's t-test of two means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Welch {
    /// The statistic: first mean minus second, over the standard error of the difference.
    pub t: f64,
    /// Degrees of freedom (Welch & Satterthwaite).
    pub degrees: f64,
    /// Two-sided probability of a statistic at least as large.
    pub p: f64,
    /// Two-sided critical value at 5 %.
    pub critical: f64,
}

/// Welch's test of `a` against `b`; `None` if a sample has fewer than two values or neither varies.
#[must_use]
pub fn welch(a: &Sample, b: &Sample) -> Option<Welch> {
    let (va, vb) = (a.variance_of_mean()?, b.variance_of_mean()?);
    let variance = va + vb;
    if variance <= 0.0 {
        return None;
    }
    let t = (a.mean? - b.mean?) / variance.sqrt();
    let degrees = variance.powi(2) / (va.powi(2) / (a.count - 1) as f64 + vb.powi(2) / (b.count - 1) as f64);
    let student = StudentsT::new(0.0, 1.0, degrees).ok()?;
    Some(Welch { t, degrees, p: 2.0 * student.sf(t.abs()), critical: student.inverse_cdf(0.975) })
}

/// Student's t of two means with pooled variance. `None` if a sample has fewer than two values or neither varies.
#[must_use]
pub fn student(a: &Sample, b: &Sample) -> Option<f64> {
    let (na, nb) = (a.count as f64, b.count as f64);
    let pooled = ((na - 1.0) * a.sd?.powi(2) + (nb - 1.0) * b.sd?.powi(2)) / (na + nb - 2.0);
    let error = (pooled * (1.0 / na + 1.0 / nb)).sqrt();
    (error > 0.0).then_some((a.mean? - b.mean?) / error)
}

/// Fisher's exact test, one-sided: the probability of as few successes of `a` or fewer if both shares are
/// equal, given the successes of both together. `None` if either count is 0.
#[must_use]
pub fn fisher_below((successes_a, count_a): (u64, u64), (successes_b, count_b): (u64, u64)) -> Option<f64> {
    if count_a == 0 || count_b == 0 {
        return None;
    }
    let draws = Hypergeometric::new(count_a + count_b, successes_a + successes_b, count_a).ok()?;
    Some(draws.cdf(successes_a))
}

/// Welch's test, one-sided: the probability of a difference `a` minus `b` at least as large if the mean of `a`
/// is not the larger one. Small if `a` is significantly above `b`.
#[must_use]
pub fn welch_above(a: &Sample, b: &Sample) -> Option<f64> {
    let Welch { t, degrees, .. } = welch(a, b)?;
    Some(StudentsT::new(0.0, 1.0, degrees).ok()?.sf(t))
}

/// Difference of two means in standard errors of the difference; `None` where [`welch`] is.
#[must_use]
pub fn mean_difference(a: &Sample, b: &Sample) -> Option<f64> {
    welch(a, b).map(|welch| welch.t)
}

/// Difference of two shares in standard errors under one pooled share; 0 if both are 0 or both are 1. `None` if
/// either count is 0.
#[must_use]
pub fn share_difference(
    (successes_a, count_a): (u64, u64),
    (successes_b, count_b): (u64, u64),
) -> Option<f64> {
    if count_a == 0 || count_b == 0 {
        return None;
    }
    let (na, nb) = (count_a as f64, count_b as f64);
    let (a, b) = (successes_a as f64 / na, successes_b as f64 / nb);
    let pooled = (successes_a + successes_b) as f64 / (na + nb);
    let error = (pooled * (1.0 - pooled) * (1.0 / na + 1.0 / nb)).sqrt();
    Some(if error > 0.0 { (a - b) / error } else { 0.0 })
}
