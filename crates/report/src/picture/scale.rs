//! Ticks at round numbers along an axis, and ranges of values.

use contract::Range;

/// Multiples of 1, 2 or 5 times a power of ten within a range.
#[derive(Clone, Copy, Debug)]
pub struct Ticks {
    first: i64,
    last: i64,
    /// The step is `digit` times ten to the `exponent`.
    digit: i64,
    exponent: i32,
}

impl Ticks {
    /// The finest ticks over `range` with at most `count` of them; whole numbers if the range is a point.
    pub fn over(range: Range, count: usize) -> Self {
        let width = range.max - range.min;
        let one =
            Self { first: range.min.ceil() as i64, last: range.max.floor() as i64, digit: 1, exponent: 0 };
        if width <= 0.0 {
            return one;
        }
        let rough = (libm::log10(width).floor() as i32 - 2).max(-12);
        let steps = (rough..rough + 5).flat_map(|exponent| [1, 2, 5].map(|digit| (digit, exponent)));
        let mut ticks = steps.map(|(digit, exponent)| {
            let step = step(digit, exponent);
            // Tolerates rounding: a tick at the very end of the range must be kept.
            let slack = 1e-9 * width / step;
            let first = (range.min / step - slack).ceil() as i64;
            Self { first, last: (range.max / step + slack).floor() as i64, digit, exponent }
        });
        let fits = |ticks: &Self| ticks.last - ticks.first < count as i64;
        ticks.find(fits).unwrap_or(one)
    }

    /// Each tick with its label.
    pub fn labels(self) -> impl Iterator<Item = (f64, String)> {
        let decimals = usize::try_from(-self.exponent).unwrap_or(0);
        (self.first..=self.last).map(move |n| {
            let value = n as f64 * step(self.digit, self.exponent);
            (value, format!("{value:.decimals$}").replace('-', "−"))
        })
    }
}

/// Smallest and largest of `values`; `None` without values.
pub fn range(values: impl IntoIterator<Item = f64>) -> Option<Range> {
    let points = values.into_iter().map(|value| Range { min: value, max: value });
    points.reduce(|range, value| Range { min: range.min.min(value.min), max: range.max.max(value.max) })
}

fn step(digit: i64, exponent: i32) -> f64 {
    let power = 10_f64.powi(exponent.abs());
    if exponent < 0 { digit as f64 / power } else { digit as f64 * power }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(min: f64, max: f64, need: &str) {
        let labels: Vec<String> =
            Ticks::over(Range { min, max }, 8).labels().map(|(_, label)| label).collect();
        assert_eq!(labels.join(" "), need, "{min} to {max}");
    }

    #[test]
    fn ticks_are_round_and_within_the_range() {
        check(0.0, 19.0, "0 5 10 15");
        check(-0.159, 0.161, "−0.15 −0.10 −0.05 0.00 0.05 0.10 0.15");
        check(-4400.0, -4139.0, "−4400 −4350 −4300 −4250 −4200 −4150");
        check(0.0, 991.02, "0 200 400 600 800");
        check(0.0, 0.0, "0");
    }
}
