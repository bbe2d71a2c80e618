//! Points by place: the map is bounded and the points are spread over it, so square buckets find neighbours in constant time.

use rover::{Lattice, Point};

/// Points in square buckets, numbered in the order of insertion.
#[derive(Clone, Debug)]
pub struct BucketGrid {
    side_m: f64,
    columns: usize,
    rows: usize,
    buckets: Vec<Vec<(Point, u32)>>,
    points: u32,
}

impl BucketGrid {
    /// An empty grid over the map, with buckets for about two of `expected` points each.
    #[must_use]
    pub fn new(lattice: Lattice, expected: usize) -> Self {
        let side_m = (2.0 * lattice.cells() as f64 / expected.max(1) as f64).sqrt().max(0.5);
        let columns = (lattice.width() as f64 / side_m) as usize + 1;
        let rows = (lattice.height() as f64 / side_m) as usize + 1;
        Self { side_m, columns, rows, buckets: vec![Vec::new(); columns * rows], points: 0 }
    }

    fn place(&self, point: Point) -> (usize, usize) {
        // `as` saturates at 0.
        let column = ((point.x_m / self.side_m) as usize).min(self.columns - 1);
        let row = ((point.y_m / self.side_m) as usize).min(self.rows - 1);
        (column, row)
    }

    /// Adds a point, which gets the next number.
    pub fn insert(&mut self, point: Point) {
        let (column, row) = self.place(point);
        self.buckets[row * self.columns + column].push((point, self.points));
        self.points += 1;
    }

    /// Writes the numbers of all points within `radius_m` to `found`, with their distances; in a fixed order, not by distance.
    pub fn within(&self, point: Point, radius_m: f64, found: &mut Vec<(f64, u32)>) {
        found.clear();
        let (west, south) = self.place(Point::new(point.x_m - radius_m, point.y_m - radius_m));
        let (east, north) = self.place(Point::new(point.x_m + radius_m, point.y_m + radius_m));
        for row in south..=north {
            for bucket in &self.buckets[row * self.columns + west..=row * self.columns + east] {
                for &(other, number) in bucket {
                    let away_m = point.distance_m(other);
                    if away_m <= radius_m {
                        found.push((away_m, number));
                    }
                }
            }
        }
    }

    /// Writes the `count` nearest points to `found`, nearest first, of equal ones the earlier first.
    pub fn nearest(&self, point: Point, count: usize, found: &mut Vec<(f64, u32)>) {
        found.clear();
        let (column, row) = self.place(point);
        for ring in 0..self.columns.max(self.rows) {
            // Buckets of this ring are at least so far away.
            let least_m = (ring as f64 - 1.0) * self.side_m;
            if found.len() == count && found[count - 1].0 < least_m {
                return;
            }
            let (south, north) = (row.saturating_sub(ring), (row + ring).min(self.rows - 1));
            let (west, east) = (column.saturating_sub(ring), (column + ring).min(self.columns - 1));
            for y in south..=north {
                let whole = y + ring == row || y == row + ring;
                let step = if whole || ring == 0 { 1 } else { 2 * ring };
                // Off the map in the west, only the eastern column of the ring is left.
                let first = if whole || column >= ring { west } else { column + ring };
                for x in (first..=east).step_by(step) {
                    self.offer(point, &self.buckets[y * self.columns + x], count, found);
                }
            }
        }
    }

    fn offer(&self, point: Point, bucket: &[(Point, u32)], count: usize, found: &mut Vec<(f64, u32)>) {
        for &(other, number) in bucket {
            let candidate = (point.distance_m(other), number);
            let rank = found.partition_point(|known| *known < candidate);
            if rank < count {
                found.truncate(count - 1);
                found.insert(rank, candidate);
            }
        }
    }
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
