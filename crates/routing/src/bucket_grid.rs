//! Points by place: the map is bounded and the points are spread over it, so square buckets find neighbours in constant time.

use rover::{Lattice, Point};

/// Points in square buckets, numbered in the order of insertion.
///
/// While there are few points, four, 16, 64, ... of the final buckets are one, so that a search does not pass many empty ones.
#[derive(Clone, Debug)]
pub struct BucketGrid {
    /// Side of a final bucket.
    side_m: f64,
    /// Final buckets.
    columns: usize,
    rows: usize,
    /// A bucket holds 2 to this power final ones in each direction.
    level: u32,
    buckets: Vec<Bucket>,
    /// What does not fit into the buckets.
    rest: Vec<Vec<(Point, u32)>>,
    /// By number, with the final bucket of each.
    points: Vec<(Point, u32)>,
}

/// The first points of a bucket, side by side with those of its neighbours.
#[derive(Clone, Debug, Default)]
struct Bucket {
    x_m: [f64; Bucket::ROOM],
    y_m: [f64; Bucket::ROOM],
    number: [u32; Bucket::ROOM],
    held: u32,
    /// Place of the others in the rest, counted from 1; 0 if there are none.
    rest: u32,
}

impl Bucket {
    const ROOM: usize = 4;
}

/// What a square of a distance may be above that of a greater one by rounding.
const ROUNDING: f64 = 1.0 + 1e-12;

impl BucketGrid {
    /// Points to a bucket before the buckets are divided.
    const FILL: usize = 2;

    /// An empty grid over the map, with buckets for about two of `expected` points each.
    #[must_use]
    pub fn new(lattice: Lattice, expected: usize) -> Self {
        let side_m = (2.0 * lattice.cells() as f64 / expected.max(1) as f64).sqrt().max(0.5);
        let columns = (lattice.width() as f64 / side_m) as usize + 1;
        let rows = (lattice.height() as f64 / side_m) as usize + 1;
        let level = columns.max(rows).ilog2();
        let mut grid =
            Self { side_m, columns, rows, level, buckets: Vec::new(), rest: Vec::new(), points: Vec::new() };
        grid.buckets = vec![Bucket::default(); grid.width() * grid.height()];
        grid
    }

    /// Buckets in a row.
    fn width(&self) -> usize {
        ((self.columns - 1) >> self.level) + 1
    }

    /// Rows of buckets.
    fn height(&self) -> usize {
        ((self.rows - 1) >> self.level) + 1
    }

    /// Column and row of the final bucket.
    #[inline]
    fn place(&self, point: Point) -> (usize, usize) {
        // `as` saturates at 0.
        let column = ((point.x_m / self.side_m) as usize).min(self.columns - 1);
        let row = ((point.y_m / self.side_m) as usize).min(self.rows - 1);
        (column, row)
    }

    /// Adds a point, which gets the next number.
    pub fn insert(&mut self, point: Point) {
        let (column, row) = self.place(point);
        self.points.push((point, (row * self.columns + column) as u32));
        if self.level > 0 && self.points.len() > Self::FILL * self.buckets.len() {
            self.divide();
        } else {
            self.hold(self.points.len() - 1);
        }
    }

    /// Makes four buckets of one.
    fn divide(&mut self) {
        self.level -= 1;
        self.buckets.clear();
        self.buckets.resize(self.width() * self.height(), Bucket::default());
        self.rest.clear();
        for number in 0..self.points.len() {
            self.hold(number);
        }
    }

    /// Puts a point into its bucket.
    fn hold(&mut self, number: usize) {
        let (point, place) = self.points[number];
        let (column, row) = (place as usize % self.columns, place as usize / self.columns);
        let at = (row >> self.level) * self.width() + (column >> self.level);
        let bucket = &mut self.buckets[at];
        let held = bucket.held as usize;
        if held < Bucket::ROOM {
            bucket.x_m[held] = point.x_m;
            bucket.y_m[held] = point.y_m;
            bucket.number[held] = number as u32;
            bucket.held += 1;
            return;
        }
        if bucket.rest == 0 {
            self.rest.push(Vec::new());
            bucket.rest = self.rest.len() as u32;
        }
        self.rest[bucket.rest as usize - 1].push((point, number as u32));
    }

    /// Calls `visit` with the points of a bucket in the order of their numbers.
    #[inline]
    fn each(&self, bucket: &Bucket, mut visit: impl FnMut(Point, u32)) {
        for at in 0..(bucket.held as usize).min(Bucket::ROOM) {
            visit(Point::new(bucket.x_m[at], bucket.y_m[at]), bucket.number[at]);
        }
        if bucket.rest > 0 {
            for (point, number) in &self.rest[bucket.rest as usize - 1] {
                visit(*point, *number);
            }
        }
    }

    /// Writes the numbers of all points within `radius_m` to `found`, with their distances; in a fixed order, not by distance.
    pub fn within(&self, point: Point, radius_m: f64, found: &mut Vec<(f64, u32)>) {
        found.clear();
        let (west, south) = self.place(Point::new(point.x_m - radius_m, point.y_m - radius_m));
        let (east, north) = self.place(Point::new(point.x_m + radius_m, point.y_m + radius_m));
        let (width, beyond) = (self.width(), radius_m * radius_m * ROUNDING);
        for row in south >> self.level..=north >> self.level {
            let row = row * width;
            for bucket in &self.buckets[row + (west >> self.level)..=row + (east >> self.level)] {
                self.each(bucket, |other, number| {
                    let (dx, dy) = (other.x_m - point.x_m, other.y_m - point.y_m);
                    if dx * dx + dy * dy <= beyond {
                        let away_m = point.distance_m(other);
                        if away_m <= radius_m {
                            found.push((away_m, number));
                        }
                    }
                });
            }
        }
        if self.level > 0 {
            // In the order of the final buckets.
            found.sort_unstable_by_key(|(_, number)| (self.points[*number as usize].1, *number));
        }
    }

    /// Writes the `count` nearest points to `found`, nearest first, of equal ones the earlier first.
    pub fn nearest(&self, point: Point, count: usize, found: &mut Vec<(f64, u32)>) {
        found.clear();
        let (column, row) = self.place(point);
        let (column, row) = (column >> self.level, row >> self.level);
        let (width, height) = (self.width(), self.height());
        let side_m = self.side_m * (1_u64 << self.level) as f64;
        // From the point to the nearest border of its bucket, less what may be rounded.
        let (x_m, y_m) = (point.x_m - column as f64 * side_m, point.y_m - row as f64 * side_m);
        let inner_m = x_m.min(side_m - x_m).min(y_m).min(side_m - y_m) - 1e-9;
        for ring in 0..width.max(height) {
            // Buckets of this ring are at least so far away.
            let least_m = (ring as f64 - 1.0) * side_m + inner_m;
            if found.len() == count && found[count - 1].0 < least_m {
                return;
            }
            let (south, north) = (row.saturating_sub(ring), (row + ring).min(height - 1));
            let (west, east) = (column.saturating_sub(ring), (column + ring).min(width - 1));
            for y in south..=north {
                let whole = y + ring == row || y == row + ring;
                let step = if whole || ring == 0 { 1 } else { 2 * ring };
                // Off the map in the west, only the eastern column of the ring is left.
                let first = if whole || column >= ring { west } else { column + ring };
                for x in (first..=east).step_by(step) {
                    let away_x_m = away_m(point.x_m, x as f64 * side_m, side_m);
                    let away_y_m = away_m(point.y_m, y as f64 * side_m, side_m);
                    let reach = reach(found, count);
                    if away_x_m * away_x_m + away_y_m * away_y_m <= reach {
                        self.offer(point, &self.buckets[y * width + x], count, found);
                    }
                }
            }
        }
    }

    #[inline]
    fn offer(&self, point: Point, bucket: &Bucket, count: usize, found: &mut Vec<(f64, u32)>) {
        let mut beyond = reach(found, count);
        self.each(bucket, |other, number| {
            let (dx, dy) = (other.x_m - point.x_m, other.y_m - point.y_m);
            if dx * dx + dy * dy > beyond {
                return;
            }
            let candidate = (point.distance_m(other), number);
            if found.len() == count {
                if candidate >= found[count - 1] {
                    return;
                }
                found.pop();
            }
            let rank = found.partition_point(|known| *known < candidate);
            found.insert(rank, candidate);
            beyond = reach(found, count);
        });
    }
}

/// The square of the distance beyond which no point is among the nearest `count`.
#[inline]
fn reach(found: &[(f64, u32)], count: usize) -> f64 {
    if found.len() == count { found[count - 1].0 * found[count - 1].0 * ROUNDING } else { f64::INFINITY }
}

/// How far a number is at least from an interval, whose ends may be rounded.
#[inline]
fn away_m(at_m: f64, from_m: f64, length_m: f64) -> f64 {
    (from_m - at_m).max(at_m - (from_m + length_m)).max(1e-9) - 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn neighbours_are_those_of_a_search_over_all_points(
            points in prop::collection::vec((0.0..=50.0_f64, 0.0..=20.0_f64), 1..60),
            expected in 1..200_usize, at in (0.0..=50.0_f64, 0.0..=20.0_f64), count in 1..9_usize, radius_m in 0.0..30.0_f64,
        ) {
            let lattice = Lattice::new(50, 20).unwrap();
            let mut grid = BucketGrid::new(lattice, expected);
            let at = Point::new(at.0, at.1);
            let mut all = Vec::new();
            for (number, (x_m, y_m)) in points.into_iter().enumerate() {
                let point = Point::new(x_m, y_m);
                grid.insert(point);
                all.push((at.distance_m(point), number as u32));
            }
            all.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let mut found = Vec::new();
            grid.nearest(at, count, &mut found);
            prop_assert_eq!(&found, &all[..count.min(all.len())]);
            grid.within(at, radius_m, &mut found);
            found.sort_by(|a, b| a.partial_cmp(b).unwrap());
            all.retain(|known| known.0 <= radius_m);
            prop_assert_eq!(found, all);
        }
    }
}
