//! The test of suspicion: values that stand for cells without data, though the file does not say so.
//!
//! A value is suspected if it is the lowest or the highest of all, and lies far outside of the others: nearer if it is one
//! that programs write for nodata, or if many cells hold it to the last bit, as cells of ground do not.

use std::fmt;

use contract::Range;
use serde::Serialize;

/// Lowest values that programs write for nodata.
const USUAL_LOWEST: [f64; 10] =
    [-9999.0, -9999.9, -9999.99, -99999.0, -99999.99, -99999.9, -32768.0, -32767.0, -10000.0, -100_000.0];

/// Values that programs write for nodata, but that may be heights as well.
const USUAL_SOMETIMES: [f64; 11] =
    [-999.0, -999.9, -999.99, -99.0, 999.0, 9999.0, 99_999.0, 32767.0, 65535.0, 10_000.0, 100_000.0];

/// The highest values of bytes, which are nodata in layers, and in heights of bytes.
const USUAL_BYTES: [f64; 2] = [255.0, 127.0];

/// Gap to the nearest other value, in ranges of all others, from which a value is suspected.
const GAP_USUAL: f64 = 0.01;
const GAP_PLATEAU: f64 = 0.5;
const GAP_SINGLE: f64 = 10.0;

/// The same where the gap is also this many times wider than any gap between the others.
const GAP_PLATEAU_WIDE: f64 = 0.1;
const WIDER: f64 = 20.0;

/// Fewest cells of a plateau.
const PLATEAU_CELLS_MIN: u64 = 4;

/// Fewest different values besides, for numbers to be measured and not codes or shares.
const DIFFERENT_MIN: usize = 8;

/// Most values of one file that are suspected; each is the extreme of what is left.
const FILLS_MAX: usize = 4;

/// Most values that the gaps between others are taken from.
const SAMPLED_MAX: usize = 1 << 16;

/// What is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Values {
    /// Heights of ground.
    Heights,
    /// Heights that were stored as bytes.
    ByteHeights,
    /// Codes or shares, 0 or more.
    Layer,
}

/// A value that looks like nodata which the file does not declare. Displayed, it is what is suspected, and of how many cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fill {
    /// The value, as the file stores it: before scale, offset and unit.
    pub value: f64,
    /// Cells that hold it.
    pub cells: u64,
    /// Lowest and highest of all other values, as stored.
    pub others: Range,
}

impl fmt::Display for Fill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cells, others, .. } = self;
        let [min, max] = [others.min, others.max].map(seven_digits);
        let value = self.in_words();
        let cells = if *cells == 1 { "1 cell holds it".into() } else { format!("{cells} cells hold it") };
        write!(
            f,
            "{value} looks like nodata that the file does not declare ({cells}, all others are from {min} to {max})"
        )
    }
}

impl Fill {
    /// The value in as few digits as tell it from its neighbours, those of float32 if it is such a number.
    #[must_use]
    pub fn in_words(&self) -> String {
        let single = self.value as f32;
        if f64::from(single) == self.value { single.to_string() } else { self.value.to_string() }
    }
}

/// A value with seven digits, which is what float32 has.
fn seven_digits(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// Takes what is suspected out of `values`: NaN stands in its place, as it does for declared nodata.
pub(crate) fn remove(values: &mut [f64], kind: Values) -> Vec<Fill> {
    let mut fills = Vec::new();
    while fills.len() < FILLS_MAX {
        let Some(fill) = suspected(values, kind) else { break };
        for value in values.iter_mut() {
            if *value == fill.value {
                *value = f64::NAN;
            }
        }
        fills.push(fill);
    }
    fills
}

fn suspected(values: &[f64], kind: Values) -> Option<Fill> {
    let known = || values.iter().copied().filter(|value| !value.is_nan());
    let min = known().reduce(f64::min)?;
    let max = known().reduce(f64::max)?;
    let mut fills = [min, max].into_iter().filter_map(|value| {
        let cells = known().filter(|other| *other == value).count() as u64;
        let others = || known().filter(move |other| *other != value);
        let range = Range { min: others().reduce(f64::min)?, max: others().reduce(f64::max)? };
        let fill = Fill { value, cells, others: range };
        let sample = || others().step_by(values.len().div_ceil(SAMPLED_MAX));
        if fill.is_far(kind, sample) { Some(fill) } else { None }
    });
    fills.next()
}

impl Fill {
    /// Whether it lies far enough outside of the others to be suspected; `others` are some of them.
    fn is_far<I: Iterator<Item = f64>>(&self, kind: Values, others: impl Fn() -> I) -> bool {
        let Range { min, max } = self.others;
        let gap = if self.value < min { min - self.value } else { self.value - max };
        let range = max - min;
        let is_among = |usual: &[f64]| usual.iter().any(|usual| *usual as f32 == self.value as f32);
        let is_usual = is_among(&USUAL_LOWEST)
            || kind == Values::Layer
                && (self.value < 0.0 && min >= 0.0 || is_among(&USUAL_SOMETIMES) || is_among(&USUAL_BYTES));
        let may_be_usual =
            is_among(&USUAL_SOMETIMES) || kind == Values::ByteHeights && is_among(&USUAL_BYTES);
        if is_usual && gap > GAP_USUAL * range || may_be_usual && gap > GAP_PLATEAU * range {
            return true;
        }
        if kind == Values::Layer {
            // Codes have gaps, and shares may be 0 and 1 alone.
            return false;
        }
        let nearest = GAP_SINGLE.min(GAP_PLATEAU).min(GAP_PLATEAU_WIDE);
        if gap <= nearest * range || !has_different(others()) {
            return false;
        }
        gap > GAP_SINGLE * range
            || self.cells >= PLATEAU_CELLS_MIN
                && (gap > GAP_PLATEAU * range || gap > WIDER * widest_gap(others().collect()))
    }
}

/// Whether there are enough different values for them to be measured.
fn has_different(others: impl Iterator<Item = f64>) -> bool {
    let mut different = Vec::new();
    for other in others {
        if !different.contains(&other) {
            different.push(other);
        }
        if different.len() >= DIFFERENT_MIN {
            return true;
        }
    }
    false
}

/// The widest gap between two values that follow each other in order.
fn widest_gap(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ground of 2000 cells from 97 to 103 m, higher by `base_m`, and `cells` of `fill`.
    fn ground(base_m: f64, fill: f64, cells: usize) -> Vec<f64> {
        let hills = (0..2000).map(|index| base_m + 100.0 + 3.0 * libm::sin(f64::from(index) / 37.0));
        hills.chain(std::iter::repeat_n(fill, cells)).collect()
    }

    /// P-DEM-FILL.
    #[test]
    fn a_value_far_outside_of_all_others_is_suspected_at_either_end() {
        for (base_m, fill, cells) in [
            (0.0, -9999.0, 1),
            (0.0, -9999.0, 5000),
            (0.0, f64::from(-9999.99f32), 100),
            (0.0, -32768.0, 3000),
            (0.0, -10000.0, 3000),
            (2600.0, 0.0, 3000),
            (2600.0, 0.0, 1),
            (0.0, 1e5, 8),
            (0.0, 32767.0, 8),
            (-4000.0, 0.0, 50),
            (0.0, 65535.0, 2),
            (0.0, 0.0, 20),
        ] {
            let mut values = ground(base_m, fill, cells);
            let fills = remove(&mut values, Values::Heights);
            let [found] = fills[..] else { panic!("{fills:?} for {fill}") };
            assert_eq!((found.value, found.cells), (fill, cells as u64));
            assert_eq!(values.iter().filter(|value| value.is_nan()).count(), cells);
        }
        let mut two = ground(0.0, -9999.0, 40);
        two.extend([32767.0; 7]);
        assert_eq!(remove(&mut two, Values::Heights).len(), 2);
        // A survey of a wide range beside a plateau of zeros that is nearer than the range.
        let mut survey: Vec<f64> = (0..4000).map(|index| 300.0 + f64::from(index) / 2.0).collect();
        survey.extend([0.0; 900]);
        assert_eq!(remove(&mut survey, Values::Heights).len(), 1);
    }

    #[test]
    fn ground_is_not_suspected() {
        let sea: Vec<f64> = (0..3000).map(|index| (f64::from(index) - 2000.0).max(0.0) / 10.0).collect();
        let mars: Vec<f64> = (0..3000).map(|index| f64::from(index) * 9.7 - 8200.0).collect();
        let whole: Vec<f64> = (0..256).map(f64::from).collect();
        let spike = [ground(0.0, 100.0, 0), vec![140.0]].concat();
        let two = vec![0.0, 90.0, 0.0, 90.0];
        for (values, kind) in [
            (ground(0.0, 100.0, 9), Values::Heights),
            (sea, Values::Heights),
            (mars, Values::Heights),
            (whole, Values::ByteHeights),
            (spike, Values::Heights),
            (two, Values::Heights),
            (vec![7.0; 50], Values::Heights),
            (vec![], Values::Heights),
            (vec![f64::NAN; 3], Values::Heights),
            ([vec![0.0; 9], vec![1.0; 9], vec![10.0; 9]].concat(), Values::Layer),
            (vec![0.0, 50.0, 150.0, 200.0], Values::Layer),
            (vec![0.0, 1.0], Values::Layer),
        ] {
            assert_eq!(remove(&mut values.clone(), kind), [], "{values:?}");
        }
    }

    #[test]
    fn in_layers_255_and_negative_values_are_suspected() {
        for fill in [255.0, -9999.0, -1.0, 65535.0, 9999.0, -128.0] {
            let mut values = vec![0.0, 1.0, fill, 1.0];
            assert_eq!(remove(&mut values, Values::Layer).len(), 1, "{fill}");
        }
    }
}
