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
        let mut columns = (u32::MAX, 0);
        let spans: Vec<(u32, u32)> = (first_row..last_row)
            .map(|row| {
                let (west, east) = interval(segment, row as f64 + 0.5, radius_m);
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

/// Where the row at `y_m` is within `radius_m` of the segment, from west to east; an empty interval if nowhere.
fn interval(segment: Segment, y_m: f64, radius_m: f64) -> (f64, f64) {
    let Segment { from, to } = segment;
    let mut hull = (f64::INFINITY, f64::NEG_INFINITY);
    for end in [from, to] {
        let half = radius_m * radius_m - (y_m - end.y_m).powi(2);
        if half >= 0.0 {
            let half = half.sqrt();
            hull = (hull.0.min(end.x_m - half), hull.1.max(end.x_m + half));
        }
    }
    // Between the two discs: 0 ≤ along ≤ length, |across| ≤ radius, both linear in x.
    let length_m = from.distance_m(to);
    if length_m == 0.0 {
        return hull;
    }
    let (ux, uy) = ((to.x_m - from.x_m) / length_m, (to.y_m - from.y_m) / length_m);
    let dy = y_m - from.y_m;
    let mut slab = (f64::NEG_INFINITY, f64::INFINITY);
    for (factor, offset, low, high) in [(ux, uy * dy, 0.0, length_m), (uy, -ux * dy, -radius_m, radius_m)] {
        if factor.abs() > 1e-12 {
            let (a, b) = ((low - offset) / factor, (high - offset) / factor);
            slab = (slab.0.max(a.min(b)), slab.1.min(a.max(b)));
        } else if offset < low || offset > high {
            return hull;
        }
    }
    if slab.0 <= slab.1 { (hull.0.min(from.x_m + slab.0), hull.1.max(from.x_m + slab.1)) } else { hull }
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
