//! The test of suspicion: values that stand for cells without data, though the file does not say so.
//!
//! Suspected are the outermost values of a file, at one end or at both, if each of them lies far outside of what is left
//! without all of them: nearer if it is one that programs write for nodata, or if many cells hold it to the last bit, as
//! cells of ground do not.

use std::fmt;

use contract::Range;
use serde::Serialize;

/// Lowest values that programs write for nodata; those from -32768 to -32764 are the special pixels of ISIS.
const USUAL_LOWEST: [f64; 13] = [
    -9999.0, -9999.9, -9999.99, -99999.0, -99999.99, -99999.9, -32768.0, -32767.0, -32766.0, -32765.0,
    -32764.0, -10000.0, -100_000.0,
];

/// Values that programs write for nodata, but that may be heights as well.
const USUAL_SOMETIMES: [f64; 11] =
    [-999.0, -999.9, -999.99, -99.0, 999.0, 9999.0, 99_999.0, 32767.0, 65535.0, 10_000.0, 100_000.0];

/// The highest values of bytes, which are nodata in layers, and in heights of bytes.
const USUAL_BYTES: [f64; 2] = [255.0, 127.0];

/// Bytes from here on may be further codes for nodata below one that is.
const CODE_OF_NODATA_MIN: f64 = 249.0;

/// Gap to what is left, in ranges of it, from which a value is suspected.
const GAP_USUAL: f64 = 0.01;
const GAP_PLATEAU: f64 = 0.5;
const GAP_FAR: f64 = 10.0;

/// A plateau is suspected from this gap on, too, where it is so many times wider than any gap within what is left.
const GAP_PLATEAU_WIDE: f64 = 0.1;
const WIDER: f64 = 20.0;

/// Fewest cells of a plateau.
const PLATEAU_CELLS_MIN: u64 = 4;

/// Several plateaus at one end are suspected together if they lie closer to each other than this share of their gap.
const NARROW: f64 = 0.05;

/// Fewest different values in what is left, for numbers to be measured and not codes, shares or steps.
const DIFFERENT_MIN: usize = 8;

/// The range of what is left counts as no less than this where it has fewer different values, or a single one; metres.
const RANGE_OF_FEW_M: f64 = 10.0;
const RANGE_OF_ONE_M: f64 = 100.0;

/// Fewest cells left for each cell of values that are no plateaus.
const LEFT_FOR_SINGLE: u64 = 10;

/// Most values that are suspected at either end.
const ENDS_MAX: usize = 8;

/// Outermost values that are kept of either end: those that may be suspected, and enough to count the different ones left.
const KEPT: usize = ENDS_MAX + DIFFERENT_MIN;

/// Most values that the gaps between others are taken from.
const SAMPLED_MAX: usize = 1 << 16;

/// What is tested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Test {
    pub kind: Kind,
    /// One stored unit, metres.
    pub unit_m: f64,
    /// The numbers at the ends of the type of a cell, where that is an integer of 16 bits or more.
    pub limits: &'static [f64],
}

/// What the values are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
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
    /// Cells that hold the value, among the cells that were read.
    pub cells: u64,
    /// Lowest and highest of the values that are not suspected, as stored; `None` if there are no others.
    pub others: Option<Range>,
}

impl fmt::Display for Fill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let others = match self.others {
            Some(Range { min, max }) => {
                format!("all others are from {} to {}", seven_digits(min), seven_digits(max))
            }
            None => "there are no others".into(),
        };
        let value = self.in_words();
        let cells = match self.cells {
            1 => "1 cell holds it".into(),
            cells => format!("{cells} cells hold it"),
        };
        write!(f, "{value} looks like nodata that the file does not declare ({cells}, {others})")
    }
}

impl Fill {
    /// The value in as few digits as tell it from its neighbours, those of float32 if it is such a number.
    #[must_use]
    pub fn in_words(&self) -> String {
        in_words(self.value)
    }
}

/// A value in as few digits as tell it from its neighbours, those of float32 if it is such a number.
pub(crate) fn in_words(value: f64) -> String {
    let single = value as f32;
    let is_single = f64::from(single) == value;
    match value.abs() < 1e15 {
        // Whole numbers have all their digits: those of integers are rounded by none of the two.
        true if value.fract() == 0.0 || !is_single => value.to_string(),
        true => single.to_string(),
        false if is_single => format!("{single:e}"),
        false => format!("{value:e}"),
    }
}

/// A value with seven digits, which is what float32 has.
fn seven_digits(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// Takes what is suspected out of `values`: NaN stands in its place, as it does for declared nodata.
///
/// `sample` are values of the whole file, so that every part of it is judged alike; empty if `values` are the whole.
pub(crate) fn remove(values: &mut [f64], sample: &[f64], test: Test) -> Vec<Fill> {
    let mut fills = take(values, test.suspected(values, sample, GAP_PLATEAU));
    // What is usual in the file may still stand out of a part of it, if it does so by far. Codes are codes everywhere.
    if !sample.is_empty() && test.kind != Kind::Layer {
        fills.extend(take(values, test.suspected(values, &[], GAP_FAR)));
    }
    fills
}

/// Takes values out of `values` and `sample` that cannot be any of a layer; what was in `values`.
pub(crate) fn remove_beyond(
    values: &mut [f64],
    sample: &mut [f64],
    is_beyond: impl Fn(f64) -> bool,
) -> Vec<Fill> {
    let mut others: Option<Range> = None;
    for value in
        values.iter().chain(sample.iter()).copied().filter(|value| value.is_finite() && !is_beyond(*value))
    {
        let Range { min, max } = others.unwrap_or(Range { min: value, max: value });
        others = Some(Range { min: min.min(value), max: max.max(value) });
    }
    let mut fills: Vec<Fill> = Vec::new();
    for value in values.iter_mut().filter(|value| is_beyond(**value)) {
        match fills.iter().position(|fill| fill.value == *value) {
            Some(index) => fills[index].cells += 1,
            None if fills.len() < ENDS_MAX => fills.push(Fill { value: *value, cells: 1, others }),
            None => {}
        }
        *value = f64::NAN;
    }
    sample.iter_mut().filter(|value| is_beyond(**value)).for_each(|value| *value = f64::NAN);
    fills.retain(|fill| fill.value.is_finite());
    fills
}

/// Replaces what was `found` in `values`; what was replaced, with the number of its cells.
fn take(values: &mut [f64], found: Vec<Fill>) -> Vec<Fill> {
    let counted = found.into_iter().map(|mut fill| {
        for value in values.iter_mut().filter(|value| **value == fill.value) {
            *value = f64::NAN;
            fill.cells += 1;
        }
        fill
    });
    counted.filter(|fill| fill.cells > 0).collect()
}

/// A value with the number of cells that hold it.
type Counted = (f64, u64);

/// Counts `value` among the outermost ones, if it is one of them; `inwards` is 1 from the lowest on, -1 from the highest.
fn count(outermost: &mut Vec<Counted>, value: f64, inwards: f64) {
    if outermost.len() == KEPT && outermost.last().is_some_and(|last| inwards * value > inwards * last.0) {
        return;
    }
    // No sign before a zero.
    let key = |value: f64| inwards * value + 0.0;
    match outermost.binary_search_by(|other| key(other.0).total_cmp(&key(value))) {
        Ok(index) => outermost[index].1 += 1,
        Err(index) => {
            outermost.insert(index, (value, 1));
            outermost.truncate(KEPT);
        }
    }
}

/// What is left of the values without the outermost ones that are set aside.
struct Rest<'a> {
    range: Range,
    cells: u64,
    /// How many different values it has, if they are fewer than [`DIFFERENT_MIN`].
    different: usize,
    /// Some of the values, in order.
    sorted: &'a [f64],
    /// Gap from which a plateau is suspected, in ranges.
    gap_plateau: f64,
}

impl Test {
    /// The values to suspect among `values` and `sample`: of all ways to set outermost values aside so that each of them lies
    /// far outside of the rest, the one that takes most of the usual ones; then that leaves most different values, up to as many
    /// as can be measured; then that takes most values, and the fewest cells.
    fn suspected(self, values: &[f64], sample: &[f64], gap_plateau: f64) -> Vec<Fill> {
        let known = || values.iter().chain(sample).copied().filter(|value| value.is_finite());
        let (mut low, mut high, mut all) = (Vec::new(), Vec::new(), 0);
        for value in known() {
            count(&mut low, value, 1.0);
            count(&mut high, value, -1.0);
            all += 1;
        }
        let fill = |others| move |value: &Counted| Fill { value: value.0, cells: 0, others };
        if low.len() <= ENDS_MAX && low.iter().all(|&(value, _)| self.is_nothing_else(value)) {
            return low.iter().map(fill(None)).collect();
        }
        let step = (values.len() + sample.len()).div_ceil(SAMPLED_MAX).max(1);
        let mut sorted: Vec<f64> = known().step_by(step).collect();
        sorted.sort_by(f64::total_cmp);
        let mut best = None;
        let mut most = Default::default();
        for lows in 0..=ENDS_MAX {
            for highs in 0..=ENDS_MAX {
                let (Some(min), Some(max)) = (low.get(lows), high.get(highs)) else { continue };
                let range = Range { min: min.0, max: max.0 };
                if lows + highs == 0 || range.min > range.max {
                    continue;
                }
                let aside = || low[..lows].iter().chain(&high[..highs]);
                let cells = all - aside().map(|value| value.1).sum::<u64>();
                let different = low[lows..].iter().filter(|value| value.0 <= range.max).count();
                let rest = Rest { range, cells, different, sorted: &sorted, gap_plateau };
                let usual: u32 = aside().map(|&(value, _)| self.usual_rank(value)).sum();
                let rank = (usual, different.min(DIFFERENT_MIN), lows + highs, cells);
                if rank > most && self.are_far(&low[..lows], &high[..highs], &rest) {
                    (most, best) = (rank, Some((lows, highs, range)));
                }
            }
        }
        let Some((lows, highs, range)) = best else { return Vec::new() };
        low[..lows].iter().chain(&high[..highs]).map(fill(Some(range))).collect()
    }

    /// Whether all values set aside at either end lie far outside of the rest.
    fn are_far(self, low: &[Counted], high: &[Counted], rest: &Rest) -> bool {
        let gap = |value: f64| (rest.range.min - value).max(value - rest.range.max);
        let is_usual = |value: f64| self.is_usual(value, gap(value), rest);
        if self.kind == Kind::Layer {
            // Codes have gaps, and shares may be 0 and 1 alone. Beside a usual code others mark other kinds of nodata.
            return [low, high].iter().all(|end| {
                let mut before = None;
                end.iter().all(|&(value, _)| {
                    let follows = value >= CODE_OF_NODATA_MIN
                        && before.is_some_and(|before: f64| before - value == 1.0)
                        && gap(value) > rest.range.max - rest.range.min;
                    before = Some(value);
                    is_usual(value) || follows
                })
            });
        }
        let others = |end: &[Counted]| -> Vec<Counted> {
            end.iter().copied().filter(|&(value, _)| !is_usual(value)).collect()
        };
        let [low, high] = [others(low), others(high)];
        let singles: u64 =
            low.iter().chain(&high).map(|value| value.1).filter(|cells| *cells < PLATEAU_CELLS_MIN).sum();
        if singles * LEFT_FOR_SINGLE > rest.cells || rest.has_few() && !low.is_empty() && !high.is_empty() {
            return false;
        }
        [low, high].iter().all(|end| {
            let plateaus: Vec<f64> =
                end.iter().filter(|value| value.1 >= PLATEAU_CELLS_MIN).map(|value| value.0).collect();
            // They are in order, from the outside inwards.
            let is_narrow = match (plateaus.first(), plateaus.last()) {
                (Some(first), Some(last)) => (first - last).abs() <= NARROW * gap(*last),
                _ => true,
            };
            is_narrow && end.iter().all(|&(value, cells)| rest.is_left_far(gap(value), cells, self.unit_m))
        })
    }

    /// How surely programs write `value` for nodata.
    fn usual_rank(self, value: f64) -> u32 {
        match value {
            _ if is_among(&USUAL_LOWEST, value) => 2,
            _ if value == 0.0 || is_among(&USUAL_SOMETIMES, value) || self.is_limit(value) => 1,
            _ if self.kind == Kind::Layer && !(0.0..CODE_OF_NODATA_MIN).contains(&value) => 1,
            _ => 0,
        }
    }

    /// Whether it stands for nodata even if no cell holds another value.
    fn is_nothing_else(self, value: f64) -> bool {
        is_among(&USUAL_LOWEST, value) || self.kind == Kind::Layer && (value < 0.0 || value == 255.0)
    }

    fn is_limit(self, value: f64) -> bool {
        self.limits.contains(&value)
    }

    /// Whether it is a value that programs write for nodata, and far enough outside of the rest to be one.
    fn is_usual(self, value: f64, gap: f64, rest: &Rest) -> bool {
        let Range { min, max } = rest.range;
        let is_layer = self.kind == Kind::Layer;
        let is_byte = is_among(&USUAL_BYTES, value);
        let is_sometimes = is_among(&USUAL_SOMETIMES, value);
        let is_certain = is_among(&USUAL_LOWEST, value)
            || self.is_limit(value)
            || is_layer && (value < 0.0 && min >= 0.0 || is_sometimes || is_byte);
        let may_be = is_sometimes || self.kind == Kind::ByteHeights && is_byte;
        is_certain && gap > GAP_USUAL * (max - min) || may_be && gap > GAP_PLATEAU * rest.range_m(self.unit_m)
    }
}

impl Rest<'_> {
    fn has_few(&self) -> bool {
        self.different < DIFFERENT_MIN
    }

    /// Its range, no less than what few different values count for.
    fn range_m(&self, unit_m: f64) -> f64 {
        let range = self.range.max - self.range.min;
        match self.different {
            1 => RANGE_OF_ONE_M / unit_m,
            _ if self.has_few() => range.max(RANGE_OF_FEW_M / unit_m),
            _ => range,
        }
    }

    /// Whether a value that `cells` hold and that may be any number lies far outside.
    fn is_left_far(&self, gap: f64, cells: u64, unit_m: f64) -> bool {
        let is_plateau = cells >= PLATEAU_CELLS_MIN;
        let range = self.range_m(unit_m);
        match (is_plateau, self.has_few()) {
            (false, true) => false,
            (false, false) | (true, true) => gap > GAP_FAR * range,
            (true, false) => {
                let is_wide = || gap > GAP_PLATEAU_WIDE * range && gap > WIDER * self.widest_gap();
                gap > self.gap_plateau * range || self.gap_plateau < GAP_FAR && is_wide()
            }
        }
    }

    /// The widest gap between two of its values that follow each other in order.
    fn widest_gap(&self) -> f64 {
        let Range { min, max } = self.range;
        let first = self.sorted.partition_point(|value| *value < min);
        let end = self.sorted.partition_point(|value| *value <= max);
        self.sorted[first..end].windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
    }
}

/// Whether it is one of the `usual` values, but for what float32 rounds.
fn is_among(usual: &[f64], value: f64) -> bool {
    usual.iter().any(|usual| *usual as f32 == value as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHTS: Test = Test { kind: Kind::Heights, unit_m: 1.0, limits: &[] };
    const LAYER: Test = Test { kind: Kind::Layer, ..HEIGHTS };

    /// Ground of 2000 cells from 97 to 103 m, higher by `base_m`, and `cells` of `fill`.
    fn ground(base_m: f64, fill: f64, cells: usize) -> Vec<f64> {
        let hills = (0..2000).map(|index| base_m + 100.0 + 3.0 * libm::sin(f64::from(index) / 37.0));
        hills.chain(std::iter::repeat_n(fill, cells)).collect()
    }

    /// Ground with so many cells of each of `fills`.
    fn with(fills: &[f64], cells: usize) -> Vec<f64> {
        [ground(0.0, 0.0, 0), fills.iter().flat_map(|fill| vec![*fill; cells]).collect()].concat()
    }

    /// What is suspected in `values`, from the lowest on.
    fn suspected(values: &[f64], test: Test) -> Vec<f64> {
        let mut found: Vec<f64> =
            remove(&mut values.to_vec(), &[], test).iter().map(|fill| fill.value).collect();
        found.sort_by(f64::total_cmp);
        found
    }

    /// P-DEM-FILL: Values that look like nodata are left out with the same warning in every
    /// command, until `--nodata` settles it.
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
            let fills = remove(&mut values, &[], HEIGHTS);
            let [found] = fills[..] else { panic!("{fills:?} for {fill}") };
            assert_eq!((found.value, found.cells), (fill, cells as u64));
            assert_eq!(values.iter().filter(|value| value.is_nan()).count(), cells);
        }
        // A survey of a wide range beside a plateau of zeros that is nearer than the range.
        let mut survey: Vec<f64> = (0..4000).map(|index| 300.0 + f64::from(index) / 2.0).collect();
        survey.extend([0.0; 900]);
        assert_eq!(suspected(&survey, HEIGHTS), [0.0]);
    }

    /// P-DEM-FILL. Suspicious values next to each other, or at both ends, do not hide each other.
    #[test]
    fn several_fills_are_suspected_together() {
        for fills in [
            &[-32768.0, -32767.0][..],
            &[-32768.0, -32767.0, -32766.0, -32765.0, -32764.0],
            &[-32767.0, -32766.0, -32765.0, -32764.0],
            &[-10000.0, -9999.0],
            &[-9999.99, -9999.0],
            &[-9999.0, -9998.0],
            &[-100_000.0, -99999.0],
            &[65534.0, 65535.0],
            &[0.0, 1.0],
            &[-1.0, 0.0],
            &[-9999.0, 32767.0],
            &[-9999.0, 0.0],
            &[-9999.0, -999.0, -99.0],
            &[-100_000.0, -99999.0, -32768.0, -9999.0, 9999.0, 99999.0],
        ] {
            for cells in [4, 40] {
                assert_eq!(suspected(&with(fills, cells), HEIGHTS), fills, "{cells} cells of each");
            }
        }
        for spikes in [&[-800.0, 5000.0][..], &[-800.0, -700.0, 5000.0, 5100.0]] {
            assert_eq!(suspected(&with(spikes, 1), HEIGHTS), spikes);
        }
    }

    /// P-DEM-FILL. Ground of few different values can have fills too.
    #[test]
    fn a_plateau_far_from_few_values_is_suspected() {
        for levels in [&[2700.0][..], &[2698.0, 2699.0, 2700.0, 2701.0, 2702.0], &[2699.0, 2700.0]] {
            let levels: Vec<f64> = levels.iter().flat_map(|level| [*level; 50]).collect();
            for fill in [0.0, 1.0, -1.0, -500.0, -9999.0] {
                assert_eq!(suspected(&[levels.clone(), vec![fill; 9]].concat(), HEIGHTS), [fill]);
                // Most cells may be without data.
                let most = suspected(&[levels.clone(), vec![fill; 900]].concat(), HEIGHTS);
                assert_eq!(most == [fill], levels.len() > 50 || [0.0, -9999.0].contains(&fill), "{fill}");
            }
        }
    }

    /// P-DEM-FILL. A file of nothing but a fill has no ground.
    #[test]
    fn a_usual_fill_alone_is_suspected() {
        for fills in [&[-9999.0][..], &[-32768.0], &[-32768.0, -9999.0]] {
            let values: Vec<f64> = fills.iter().flat_map(|fill| [*fill; 9]).collect();
            assert_eq!(suspected(&values, HEIGHTS), fills);
        }
        for fills in [&[255.0][..], &[-1.0], &[-9999.0, 255.0]] {
            assert_eq!(suspected(fills, LAYER), fills);
        }
        for value in [0.0, 7.0, 255.0, 9999.0, -1.0] {
            assert!(suspected(&[value; 50], HEIGHTS).is_empty(), "{value}");
        }
        assert!(suspected(&[1.0; 50], LAYER).is_empty());
    }

    /// P-DEM-FILL. A part of a file is judged by the whole file.
    #[test]
    fn the_whole_file_decides_for_each_part() {
        let whole = with(&[0.0], 900);
        assert_eq!(remove(&mut [0.0; 50], &whole, HEIGHTS)[0].cells, 50);
        let coast: Vec<f64> = (0..3000).map(|index| (f64::from(index) - 2000.0).max(0.0) / 10.0).collect();
        let cliff = [vec![0.0; 90], (0..90).map(|index| 30.0 + f64::from(index) / 10.0).collect()].concat();
        assert_eq!(suspected(&cliff, HEIGHTS), [0.0]);
        assert_eq!(remove(&mut cliff.clone(), &coast, HEIGHTS), []);
        // By far is by far.
        assert_eq!(remove(&mut with(&[-300.0], 90), &coast, HEIGHTS).len(), 1);
        let codes: Vec<f64> = (0..256).map(f64::from).collect();
        assert_eq!(remove(&mut [0.0, 255.0], &codes, LAYER), []);
    }

    #[test]
    fn the_limit_of_a_type_is_a_usual_value() {
        let heights: Vec<f64> = (0..600).map(|index| f64::from(index) * 100.0).chain([65535.0; 9]).collect();
        assert!(suspected(&heights, HEIGHTS).is_empty());
        assert_eq!(suspected(&heights, Test { limits: &[65535.0], ..HEIGHTS }), [65535.0]);
    }

    #[test]
    fn ground_is_not_suspected() {
        let bytes = Test { kind: Kind::ByteHeights, ..HEIGHTS };
        let sea: Vec<f64> = (0..3000).map(|index| (f64::from(index) - 2000.0).max(0.0) / 10.0).collect();
        let mars: Vec<f64> = (0..3000).map(|index| f64::from(index) * 9.7 - 8200.0).collect();
        let whole: Vec<f64> = (0..256).map(f64::from).collect();
        let spike = [ground(0.0, 100.0, 0), vec![140.0]].concat();
        let levels = |levels: &[f64]| levels.iter().flat_map(|level| [*level; 60]).collect::<Vec<_>>();
        let terraces = [levels(&[0.0, 1.0, 2.0, 3.0]), (10..18).map(f64::from).collect()].concat();
        for (values, test) in [
            (ground(0.0, 100.0, 9), HEIGHTS),
            (sea, HEIGHTS),
            (mars, HEIGHTS),
            (whole, bytes),
            (spike, HEIGHTS),
            (vec![0.0, 90.0, 0.0, 90.0], HEIGHTS),
            (levels(&[0.0, 90.0]), HEIGHTS),
            (levels(&[0.0, 500.0, 1000.0]), HEIGHTS),
            (levels(&[0.0, 1.0, 2.0, 50.0]), HEIGHTS),
            (terraces, HEIGHTS),
            (vec![999.0, 1000.0, 1000.0], HEIGHTS),
            (vec![0.0, 0.1, 0.2, 50.0, 51.0, 52.0, 53.0, 54.0, 55.0, 56.0, 57.0], HEIGHTS),
            (vec![7.0; 50], HEIGHTS),
            (vec![], HEIGHTS),
            (vec![f64::NAN; 3], HEIGHTS),
            (levels(&[0.0, 1.0, 10.0]), LAYER),
            (vec![0.0, 50.0, 150.0, 200.0], LAYER),
            (vec![0.0, 1.0], LAYER),
            (vec![0.0, 1.0, 254.0], LAYER),
        ] {
            let found = suspected(&values, test);
            assert!(found.is_empty(), "{found:?} of {values:?}");
        }
    }

    #[test]
    fn in_layers_255_and_negative_values_are_suspected() {
        for fill in [255.0, -9999.0, -1.0, 65535.0, 9999.0, -128.0] {
            assert_eq!(suspected(&[0.0, 1.0, fill, 1.0], LAYER), [fill]);
        }
        for fills in [&[254.0, 255.0][..], &[-9999.0, -9998.0], &[-2.0, -1.0, 255.0], &[253.0, 254.0, 255.0]]
        {
            assert_eq!(suspected(&[&[0.0, 1.0], fills].concat(), LAYER), fills);
        }
    }
}
