//! The cells seen along a straight flight.

use rover::{Lattice, Segment};

/// The cells whose middle is within the view of some point of a segment: a span of columns for each row, as the shape is convex.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Swath {
    first_row: u32,
    /// First column, and the one after the last; empty if they are equal.
    spans: Vec<(u32, u32)>,
    /// Hull of all spans.
    columns: (u32, u32),
}

impl Swath {
    /// What is seen within `radius_m` of a segment.
    #[must_use]
    pub fn new(lattice: Lattice, segment: Segment, radius_m: f64) -> Self {
        let Segment { from, to } = segment;
        let (south, north) = (from.y_m.min(to.y_m) - radius_m, from.y_m.max(to.y_m) + radius_m);
        // Rows whose middle lies between; `as` saturates at 0.
        let first_row = (south - 0.5).ceil() as usize;
        let last_row = ((north + 0.5).floor() as usize).min(lattice.height());
        let capsule = Capsule::new(segment, radius_m);
        let mut columns = (u32::MAX, 0);
        let spans: Vec<(u32, u32)> = (first_row..last_row)
            .map(|row| {
                let (west, east) = capsule.row(row as f64 + 0.5);
                let first = (west - 0.5).ceil() as usize;
                let last = ((east + 0.5).floor() as usize).min(lattice.width());
                if first < last {
                    columns = (columns.0.min(first as u32), columns.1.max(last as u32));
                    (first as u32, last as u32)
                } else {
                    (0, 0)
                }
            })
            .collect();
        Self { first_row: first_row as u32, spans, columns }
    }

    /// The swath that shows nothing.
    #[must_use]
    pub fn nothing() -> Self {
        Self { first_row: 0, spans: Vec::new(), columns: (u32::MAX, 0) }
    }

    /// The cells, row by row.
    pub fn cells(&self, lattice: Lattice) -> impl Iterator<Item = usize> {
        let rows = self.first_row as usize..;
        rows.zip(&self.spans).flat_map(move |(row, (first, end))| {
            let start = row * lattice.width();
            start + *first as usize..start + *end as usize
        })
    }

    fn rows_end(&self) -> u32 {
        self.first_row + self.spans.len() as u32
    }

    /// Whether the rectangles around two swaths overlap.
    #[must_use]
    pub fn touches(&self, other: &Self) -> bool {
        self.first_row < other.rows_end()
            && other.first_row < self.rows_end()
            && self.columns.0 < other.columns.1
            && other.columns.0 < self.columns.1
    }

    /// The span of a row; empty beyond the swath.
    #[inline]
    fn span(&self, row: u32) -> (u32, u32) {
        self.spans.get(row.wrapping_sub(self.first_row) as usize).copied().unwrap_or((0, 0))
    }
}

/// The points within a radius of a segment, cut by rows. What all rows share is computed once.
struct Capsule {
    segment: Segment,
    radius_squared: f64,
    /// Between the two discs lie the points with 0 ≤ along ≤ length and |across| ≤ radius: for each of the two conditions, half
    /// the width of its strip in x, the middle of the strip at the height of `from`, and how the middle moves with y.
    strips: [Strip; 2],
}

/// Between two parallel lines.
enum Strip {
    /// Slanted or upright lines: the interval `middle` + `shift` · dy ± `half` in x.
    Slanted { middle: f64, shift: f64, half: f64 },
    /// Level lines: all of x for these heights above `from`.
    Level { low: f64, high: f64 },
}

impl Capsule {
    fn new(segment: Segment, radius_m: f64) -> Self {
        let length_m = segment.from.distance_m(segment.to);
        let direction = segment.direction();
        let (ux, uy) = (direction.x_m, direction.y_m);
        // low ≤ x · fx + y · fy ≤ high, from `from` on.
        let strip = |fx: f64, fy: f64, low: f64, high: f64| {
            if fx.abs() > 1e-12 {
                let inverse = 1.0 / fx;
                Strip::Slanted {
                    middle: segment.from.x_m + 0.5 * (low + high) * inverse,
                    shift: -fy * inverse,
                    half: (0.5 * (high - low) * inverse).abs(),
                }
            } else if fy > 0.0 {
                Strip::Level { low: low / fy, high: high / fy }
            } else {
                Strip::Level { low: high / fy, high: low / fy }
            }
        };
        let strips = if length_m == 0.0 {
            // Nothing lies between.
            [Strip::Level { low: 1.0, high: -1.0 }, Strip::Level { low: 1.0, high: -1.0 }]
        } else {
            [strip(ux, uy, 0.0, length_m), strip(uy, -ux, -radius_m, radius_m)]
        };
        Self { segment, radius_squared: radius_m * radius_m, strips }
    }

    /// Its part of the row at `y_m`, from west to east; an empty interval if there is none.
    #[inline]
    fn row(&self, y_m: f64) -> (f64, f64) {
        let mut hull = (f64::INFINITY, f64::NEG_INFINITY);
        for end in [self.segment.from, self.segment.to] {
            let half_squared = self.radius_squared - (y_m - end.y_m) * (y_m - end.y_m);
            if half_squared >= 0.0 {
                let half = half_squared.sqrt();
                hull = (hull.0.min(end.x_m - half), hull.1.max(end.x_m + half));
            }
        }
        let dy = y_m - self.segment.from.y_m;
        let mut between = (f64::NEG_INFINITY, f64::INFINITY);
        for strip in &self.strips {
            match *strip {
                Strip::Slanted { middle, shift, half } => {
                    let middle = middle + shift * dy;
                    between = (between.0.max(middle - half), between.1.min(middle + half));
                }
                Strip::Level { low, high } if dy < low || dy > high => return hull,
                Strip::Level { .. } => {}
            }
        }
        if between.0 <= between.1 {
            hull = (hull.0.min(between.0), hull.1.max(between.1));
        }
        hull
    }
}

/// Sums of a quantity over spans of cells, each in constant time.
#[derive(Clone, Debug)]
pub struct RowSums {
    /// Sum over the cells of a row west of each column; one more entry a row than it has cells.
    west: Vec<f64>,
    stride: usize,
}

impl RowSums {
    /// Sums over `values`, in the order of the lattice's cells.
    ///
    /// # Panics
    /// If there are not as many as cells.
    #[must_use]
    pub fn new(lattice: Lattice, values: impl ExactSizeIterator<Item = f64>) -> Self {
        assert_eq!(values.len(), lattice.cells(), "row sums need a value for each cell");
        let stride = lattice.width() + 1;
        let mut west = Vec::with_capacity(stride * lattice.height());
        let mut sum = 0.0;
        for (at, value) in values.enumerate() {
            if at % lattice.width() == 0 {
                sum = 0.0;
                west.push(sum);
            }
            sum += value;
            west.push(sum);
        }
        Self { west, stride }
    }

    /// The sum over the whole map.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.west.chunks(self.stride).map(|row| row[self.stride - 1]).sum()
    }

    #[inline]
    fn sum(&self, row: u32, first: u32, end: u32) -> f64 {
        let start = row as usize * self.stride;
        self.west[start + end as usize] - self.west[start + first as usize]
    }

    /// The sum over a swath.
    #[must_use]
    pub fn all(&self, swath: &Swath) -> f64 {
        let rows = swath.first_row..;
        rows.zip(&swath.spans).map(|(row, (first, end))| self.sum(row, *first, *end)).sum()
    }

    /// The sum over the cells of `swath` that none of the `earlier` ones holds.
    #[must_use]
    pub fn fresh(&self, swath: &Swath, earlier: &[&Swath]) -> f64 {
        let mut cuts: Vec<(u32, u32)> = Vec::with_capacity(earlier.len());
        let mut sum = 0.0;
        for (row, &(first, end)) in (swath.first_row..).zip(&swath.spans) {
            cuts.clear();
            for earlier in earlier {
                let cut = earlier.span(row);
                if cut.0 < end && first < cut.1 {
                    cuts.push(cut);
                }
            }
            cuts.sort_unstable();
            let mut from = first;
            for &(cut_first, cut_end) in &cuts {
                if cut_first > from {
                    sum += self.sum(row, from, cut_first);
                }
                from = from.max(cut_end);
            }
            if from < end {
                sum += self.sum(row, from, end);
            }
        }
        sum
    }
}

/// How many cells of a rectangle have a property, in constant time.
#[derive(Clone, Debug)]
pub struct AreaCounts {
    lattice: Lattice,
    /// Cells south-west of each corner of the lattice.
    south_west: Vec<u32>,
}

impl AreaCounts {
    /// Counts the cells for which `has` is true.
    #[must_use]
    pub fn new(lattice: Lattice, has: impl Fn(usize) -> bool) -> Self {
        let stride = lattice.width() + 1;
        let mut south_west = vec![0; stride * (lattice.height() + 1)];
        for row in 0..lattice.height() {
            let mut count = 0;
            for column in 0..lattice.width() {
                count += u32::from(has(row * lattice.width() + column));
                south_west[(row + 1) * stride + column + 1] = south_west[row * stride + column + 1] + count;
            }
        }
        Self { lattice, south_west }
    }

    /// The number in the rectangle around all that is within `radius_m` of a segment: at least that in its [`Swath`].
    #[must_use]
    pub fn around(&self, segment: Segment, radius_m: f64) -> u32 {
        let Segment { from, to } = segment;
        // `as` saturates at 0.
        let column = |x_m: f64| (x_m as usize).min(self.lattice.width());
        let row = |y_m: f64| (y_m as usize).min(self.lattice.height());
        let (west, east) =
            (column(from.x_m.min(to.x_m) - radius_m), column(from.x_m.max(to.x_m) + radius_m + 1.0));
        let (south, north) =
            (row(from.y_m.min(to.y_m) - radius_m), row(from.y_m.max(to.y_m) + radius_m + 1.0));
        let at = |column: usize, row: usize| self.south_west[row * (self.lattice.width() + 1) + column];
        at(east, north) + at(west, south) - at(west, north) - at(east, south)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rover::Point;
    use std::collections::BTreeSet;

    fn distance_m(point: Point, segment: Segment) -> f64 {
        let length_m = segment.from.distance_m(segment.to);
        if length_m == 0.0 {
            return point.distance_m(segment.from);
        }
        let direction = segment.direction();
        let along =
            (point.x_m - segment.from.x_m) * direction.x_m + (point.y_m - segment.from.y_m) * direction.y_m;
        point.distance_m(segment.from.towards(segment.to, (along / length_m).clamp(0.0, 1.0)))
    }

    prop_compose! {
        fn segment()(
            from in (0.0..=40.0_f64, 0.0..=30.0_f64), to in (0.0..=40.0_f64, 0.0..=30.0_f64), level in 0..4,
        ) -> Segment {
            let from = Point::new(from.0, from.1);
            let to = match level {
                0 => Point::new(to.0, from.y_m),
                1 => Point::new(from.x_m, to.1),
                2 => from,
                _ => Point::new(to.0, to.1),
            };
            Segment { from, to }
        }
    }

    proptest! {
        #[test]
        fn a_swath_holds_the_cells_within_the_radius(segment in segment(), radius_m in 0.1..12.0_f64) {
            let lattice = Lattice::new(40, 30).unwrap();
            let seen: BTreeSet<usize> = Swath::new(lattice, segment, radius_m).cells(lattice).collect();
            for cell in 0..lattice.cells() {
                let away_m = distance_m(lattice.centre(cell), segment);
                if (away_m - radius_m).abs() > 1e-9 {
                    prop_assert_eq!(seen.contains(&cell), away_m < radius_m, "cell {} at {} m", cell, away_m);
                }
            }
        }

        #[test]
        fn the_rectangle_holds_at_least_what_the_swath_does(segment in segment(), radius_m in 0.1..12.0_f64) {
            let lattice = Lattice::new(40, 30).unwrap();
            let odd = |cell: usize| cell * cell % 7 < 3;
            let seen = Swath::new(lattice, segment, radius_m).cells(lattice).filter(|cell| odd(*cell)).count();
            let around = AreaCounts::new(lattice, odd).around(segment, radius_m) as usize;
            prop_assert!(seen <= around, "{} of {}", seen, around);
            prop_assert!(around <= lattice.cells());
        }

        #[test]
        fn fresh_cells_are_those_that_no_earlier_swath_holds(
            segments in prop::collection::vec(segment(), 1..6), radius_m in 1.0..8.0_f64,
        ) {
            let lattice = Lattice::new(40, 30).unwrap();
            let value = |cell: usize| (cell % 7) as f64;
            let sums = RowSums::new(lattice, (0..lattice.cells()).map(value));
            let swaths: Vec<Swath> =
                segments.iter().map(|segment| Swath::new(lattice, *segment, radius_m)).collect();
            let (last, earlier) = swaths.split_last().unwrap();
            let seen: BTreeSet<usize> = earlier.iter().flat_map(|swath| swath.cells(lattice)).collect();
            let expected: f64 =
                last.cells(lattice).filter(|cell| !seen.contains(cell)).map(value).sum();
            let touching: Vec<&Swath> = earlier.iter().filter(|swath| swath.touches(last)).collect();
            prop_assert_eq!(sums.fresh(last, &touching), expected);
            prop_assert_eq!(sums.all(last), last.cells(lattice).map(value).sum::<f64>());
        }
    }
}
