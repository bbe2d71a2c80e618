//! Compares the timing of two missions decision by decision with the Wilcoxon signed-rank test.
//!
//! Decision *n* of one mission is paired with decision *n* of the other, so both should be the same mission flown
//! twice: same scenario, same seed, same planner. The test asks whether the differences lie as often and as far
//! above zero as below. Unlike a t-test it assumes no shape of the distribution, which here has a long tail.

use std::collections::BTreeMap;
use std::fmt;

use contract::Decision;
use serde::Serialize;

use super::{DecisionTimings, StageTimes};
use crate::table;

/// The paired times and the result of the test. Displayed, it is text for a terminal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimingComparison {
    /// Number of decisions that both missions have.
    pub pairs: u64,
    /// Number of decisions that only one mission has.
    pub unpaired: u64,
    /// Number of pairs in which the second took longer.
    pub second_longer: u64,
    /// Number of pairs in which the second was shorter.
    pub second_shorter: u64,
    /// Median of second minus first, microseconds.
    pub median_difference_us: f64,
    /// Times of the first mission, over pairs.
    pub first: StageTimes,
    /// Times of the second mission, over pairs.
    pub second: StageTimes,
    /// Sum of the ranks of pairs in which the second took longer, W+.
    pub rank_sum: f64,
    /// W+ in standard deviations from its mean, ties and zeros left out as Wilcoxon did.
    pub z: f64,
    /// Two-sided p-value by the normal approximation, which needs some 20 pairs.
    pub p: f64,
}

/// Compares the times from landing to commit of `second` with those of `first`.
#[must_use]
pub fn compare(first: &DecisionTimings, second: &DecisionTimings) -> TimingComparison {
    let totals = |timings: &DecisionTimings| -> BTreeMap<Decision, u64> {
        timings.decisions().iter().map(|timed| (timed.decision, timed.timing.total_ns())).collect()
    };
    let (a, b) = (totals(first), totals(second));
    let pairs: Vec<(u64, u64)> =
        a.iter().filter_map(|(decision, ns)| Some((*ns, *b.get(decision)?))).collect();
    let mut differences: Vec<i128> = pairs.iter().map(|(a, b)| i128::from(*b) - i128::from(*a)).collect();
    differences.sort_unstable();
    let (rank_sum, z) = signed_rank(&differences);
    TimingComparison {
        pairs: pairs.len() as u64,
        unpaired: (a.len() + b.len() - 2 * pairs.len()) as u64,
        second_longer: differences.iter().filter(|d| **d > 0).count() as u64,
        second_shorter: differences.iter().filter(|d| **d < 0).count() as u64,
        median_difference_us: median(&differences) / 1e3,
        first: StageTimes::of(pairs.iter().map(|(a, _)| *a)),
        second: StageTimes::of(pairs.iter().map(|(_, b)| *b)),
        rank_sum,
        z,
        p: libm::erfc(z.abs() / std::f64::consts::SQRT_2),
    }
}

fn median(sorted: &[i128]) -> f64 {
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2] as f64,
        n => (sorted[n / 2 - 1] + sorted[n / 2]) as f64 / 2.0,
    }
}

/// W+ and its z: ranks of |d| over d ≠ 0, mean ranks for ties, variance lessened by Σ (t³ − t) / 48 over groups of
/// t ties (Wilcoxon 1945; Hollander & Wolfe, *Nonparametric Statistical Methods*, section 3.1).
fn signed_rank(differences: &[i128]) -> (f64, f64) {
    let mut ranked: Vec<(u128, bool)> =
        differences.iter().filter(|d| **d != 0).map(|d| (d.unsigned_abs(), *d > 0)).collect();
    ranked.sort_unstable();
    let n = ranked.len() as f64;
    let (mut rank_sum, mut ties, mut before) = (0.0, 0.0, 0.0);
    for group in ranked.chunk_by(|a, b| a.0 == b.0) {
        let t = group.len() as f64;
        let rank = before + (t + 1.0) / 2.0;
        rank_sum += rank * group.iter().filter(|(_, longer)| *longer).count() as f64;
        ties += t * t * t - t;
        before += t;
    }
    let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ties / 48.0;
    let z = if variance > 0.0 { (rank_sum - n * (n + 1.0) / 4.0) / variance.sqrt() } else { 0.0 };
    (rank_sum, z)
}

impl fmt::Display for TimingComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |us: f64| format!("{:.3}", us / 1e3);
        let row = |name: &str, times: &StageTimes| {
            [name.to_owned(), ms(times.p50_us), ms(times.p90_us), ms(times.p99_us), ms(times.max_us)]
        };
        let rows = [row("first", &self.first), row("second", &self.second)];
        f.write_str(&table(["total, ms", "p50", "p90", "p99", "max"], &rows))?;
        writeln!(
            f,
            "{} pairs by decision, {} without a partner; the second took longer in {}, shorter in {}; median \
             difference {} ms.",
            self.pairs,
            self.unpaired,
            self.second_longer,
            self.second_shorter,
            ms(self.median_difference_us)
        )?;
        writeln!(
            f,
            "Wilcoxon signed-rank test, two-sided, normal approximation: W+ = {}, z = {:.2}, p = {:.2e}.",
            self.rank_sum, self.z, self.p
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-LATENCY-COMPARE: The signed-rank sum agrees with a published example.
    ///
    /// Against Hollander & Wolfe, table 3.1 (Hamilton depression scale, nine patients): of
    /// differences before minus after, T+ = 40.
    #[test]
    fn the_signed_rank_sum_agrees_with_a_published_example() {
        let before = [1830, 500, 1620, 2480, 1680, 1880, 1550, 3060, 1300_i128];
        let after = [878, 647, 598, 2050, 1060, 1290, 1060, 3140, 1290_i128];
        let differences: Vec<i128> = before.iter().zip(after).map(|(b, a)| b - a).collect();
        let (rank_sum, z) = signed_rank(&differences);
        assert_eq!(rank_sum, 40.0);
        // E = 22.5, Var = 71.25.
        assert!((z - 17.5 / 71.25_f64.sqrt()).abs() < 1e-12, "{z}");
    }

    #[test]
    fn the_same_twice_shows_no_difference() {
        assert_eq!(signed_rank(&[0, 0, 0]), (0.0, 0.0));
        let (rank_sum, z) = signed_rank(&[-3, -2, -1, 1, 2, 3]);
        assert_eq!((rank_sum, z), (10.5, 0.0), "ties share their ranks");
    }
}
