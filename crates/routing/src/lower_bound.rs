//! A proven lower bound on the cost of every route, through any points, not only cell middles.
//!
//! Let u be a function on the map whose slope is nowhere above the cost per metre. Along any route u rises by no more than the route
//! costs, so the difference of u between goal and start is a bound. Here u is linear on triangles, two a cell, which makes its slope
//! easy to check: where it is still too steep, all of u is divided by the excess.
//!
//! How u is found matters only for how good the bound is. Fast sweeping (Zhao 2005) solves the eikonal equation |∇u| = cost at the
//! corners of the cells; where a triangle is too steep, which happens where fronts are round, its cell gets a lower cost, and the
//! equation is solved again. The best of these bounds counts.
//!
//! Slopes of the ground only lengthen ways, so the bound holds on any surface.

use rover::{CostMap, Lattice, Point};

use crate::Trip;

/// A cost that no route of the trip is below; 0 if nothing can be proven, also where the goal cannot be reached.
#[must_use]
pub fn lower_bound(costs: &CostMap, trip: &Trip) -> f64 {
    let mut certificate = Certificate::new(costs);
    let mut best = 0.0_f64;
    for _ in 0..SOLUTIONS {
        certificate.solve(trip.start);
        let steepness = certificate.steepness();
        let bound = certificate.rise(trip) / steepness;
        if bound.is_finite() {
            best = best.max(bound);
        }
        if steepness <= 1.0 {
            break;
        }
    }
    best
}

/// Solutions of the eikonal equation at most.
const SOLUTIONS: usize = 30;
/// Sweeps over all corners, in four directions each, until nothing changes.
const SWEEPS_MAX: usize = 50;
/// Changes below this share of the least cost of a metre are not worth another sweep.
const TOLERANCE: f64 = 1e-6;

/// u at the corners of the cells.
struct Certificate<'a> {
    costs: &'a CostMap,
    lattice: Lattice,
    /// Corners in a row.
    stride: usize,
    rows: usize,
    /// Cost per metre that the equation is solved with, cell by cell: at most the true one.
    lowered: Vec<f64>,
    u: Vec<f64>,
}

impl<'a> Certificate<'a> {
    fn new(costs: &'a CostMap) -> Self {
        let lattice = costs.lattice();
        let (stride, rows) = (lattice.width() + 1, lattice.height() + 1);
        Self { costs, lattice, stride, rows, lowered: costs.costs().to_vec(), u: vec![0.0; stride * rows] }
    }

    /// Solves the eikonal equation for fronts from `start`.
    fn solve(&mut self, start: Point) {
        self.u.fill(f64::INFINITY);
        let cell = self.lattice.cell(start);
        let (column, row) = (cell % self.lattice.width(), cell / self.lattice.width());
        for (column, row) in [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)] {
            let corner = Point::new(column as f64, row as f64);
            self.u[row * self.stride + column] = self.lowered[cell] * corner.distance_m(start);
        }
        for _ in 0..SWEEPS_MAX {
            if !self.sweep() {
                break;
            }
        }
    }

    /// The lowered cost of a cell, given by the place of its south-western corner; infinite off the map.
    #[inline]
    fn cost(&self, column: usize, row: usize) -> f64 {
        // West of column 0 wraps around to a number that is too large.
        if column < self.lattice.width() && row < self.lattice.height() {
            self.lowered[row * self.lattice.width() + column]
        } else {
            f64::INFINITY
        }
    }

    /// Visits the corners in four orders; whether anything changed by more than the tolerance.
    fn sweep(&mut self) -> bool {
        let mut changed = false;
        for order in 0..4 {
            for row in 0..self.rows {
                let row = if order & 1 == 0 { row } else { self.rows - 1 - row };
                for column in 0..self.stride {
                    let column = if order & 2 == 0 { column } else { self.stride - 1 - column };
                    let most = self.eikonal(column, row);
                    let u = &mut self.u[row * self.stride + column];
                    if most < *u {
                        changed |= *u - most > TOLERANCE * self.costs.least();
                        *u = most;
                    }
                }
            }
        }
        changed
    }

    /// The upwind solution over the four cells around a corner.
    #[inline]
    fn eikonal(&self, column: usize, row: usize) -> f64 {
        let mut least = f64::INFINITY;
        for (dx, dy) in [(1, 1), (-1, 1), (-1, -1), (1, -1)] {
            let cell_column = if dx > 0 { column } else { column.wrapping_sub(1) };
            let cell_row = if dy > 0 { row } else { row.wrapping_sub(1) };
            let cost = self.cost(cell_column, cell_row);
            if cost < f64::INFINITY {
                let x = self.u[row * self.stride + column.wrapping_add_signed(dx)];
                let y = self.u[row.wrapping_add_signed(dy) * self.stride + column];
                least = least.min(upwind(cost, x, y));
            }
        }
        least
    }

    /// How much steeper than allowed the steepest triangle is, at least 1: u divided by it proves the bound. Lowers the cost of
    /// the cells with such triangles.
    fn steepness(&mut self) -> f64 {
        let mut most = 1.0_f64;
        for row in 0..self.lattice.height() {
            for column in 0..self.lattice.width() {
                let cell = row * self.lattice.width() + column;
                let cost = self.costs.costs()[cell];
                if cost == f64::INFINITY {
                    continue;
                }
                let at = |dx: usize, dy: usize| self.u[(row + dy) * self.stride + column + dx];
                let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
                if a.is_finite() && b.is_finite() && c.is_finite() && d.is_finite() {
                    // A cell may be halved along either diagonal.
                    let rising = libm::hypot(b - a, c - b).max(libm::hypot(c - d, d - a));
                    let falling = libm::hypot(b - a, d - a).max(libm::hypot(c - d, c - b));
                    let excess = rising.min(falling) / cost;
                    if excess > 1.0 {
                        self.lowered[cell] /= excess;
                        most = most.max(excess);
                    }
                }
            }
        }
        most
    }

    /// u at a point, linear on its triangle: for either diagonal of the cell.
    fn at(&self, point: Point) -> [f64; 2] {
        let cell = self.lattice.cell(point);
        let (column, row) = (cell % self.lattice.width(), cell / self.lattice.width());
        let (x, y) = (point.x_m - column as f64, point.y_m - row as f64);
        let at = |dx: usize, dy: usize| self.u[(row + dy) * self.stride + column + dx];
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
        let rising = if x >= y { a + x * (b - a) + y * (c - b) } else { a + x * (c - d) + y * (d - a) };
        let falling = if x + y <= 1.0 {
            a + x * (b - a) + y * (d - a)
        } else {
            c + (1.0 - x) * (d - c) + (1.0 - y) * (b - c)
        };
        [rising, falling]
    }

    /// The least rise of u from the start to a point of the goal's disc.
    fn rise(&self, trip: &Trip) -> f64 {
        let (goal, radius_m) = (trip.goal.at, trip.goal.radius_m);
        let span = |middle: f64, cells: usize| {
            let first = (middle - radius_m).floor().max(0.0) as usize;
            first..=((middle + radius_m).floor() as usize).min(cells - 1)
        };
        let (mut steepest, mut lowest) = (0.0_f64, f64::INFINITY);
        for row in span(goal.y_m, self.lattice.height()) {
            for column in span(goal.x_m, self.lattice.width()) {
                steepest = steepest.max(self.costs.costs()[row * self.lattice.width() + column]);
                for corner in [0, 1, self.stride, self.stride + 1] {
                    lowest = lowest.min(self.u[row * self.stride + column + corner]);
                }
            }
        }
        // Two ways to bound it from below: by the corners around, and by the steepest descent from the middle.
        let [rising, falling] = self.at(goal);
        let from_middle = if steepest < f64::INFINITY {
            rising.min(falling) - radius_m * steepest
        } else {
            f64::NEG_INFINITY
        };
        let [rising, falling] = self.at(trip.start);
        lowest.max(from_middle) - rising.max(falling)
    }
}

/// The upwind u with (u − x)² + (u − y)² = cost²: a step from the lower one alone, if the higher one is not below the result.
#[inline]
fn upwind(cost: f64, x: f64, y: f64) -> f64 {
    let apart = (x - y).abs();
    if apart < cost { 0.5 * (x + y + (2.0 * cost * cost - apart * apart).sqrt()) } else { x.min(y) + cost }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Goal, ett_exact};
    use proptest::prelude::*;
    use rover::Surface;
    use std::sync::Arc;

    #[test]
    fn on_even_ground_the_bound_is_close_to_the_straight_line() {
        let lattice = Lattice::new(120, 80).unwrap();
        let map = CostMap::new(Arc::new(Surface::flat(lattice)), vec![0.005; 9600]);
        for goal in [Point::new(110.0, 60.0), Point::new(110.0, 10.2), Point::new(7.0, 71.0)] {
            let goal = Goal { at: goal, radius_m: 3.0 };
            let trip = Trip { start: Point::new(5.3, 10.1), goal };
            let share = lower_bound(&map, &trip) / (0.005 * goal.distance_m(trip.start));

            assert!((0.975..1.0 + 1e-9).contains(&share), "{share}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        /// P-ROUTE-BOUND: No route costs less than its proven lower bound.
        #[test]
        fn the_bound_is_never_above_a_route_that_was_found(
            seed in any::<u64>(), radius_m in 0.0..3.0_f64,
            from in (0.0..=8.0_f64, 0.0..=20.0_f64), to in (12.0..=20.0_f64, 0.0..=20.0_f64),
        ) {
            let lattice = Lattice::new(20, 20).unwrap();
            let noise = |cell: usize| {
                // Patches of 4 x 4 cells.
                let patch = cell / 80 * 20 + cell % 20 / 4;
                (patch as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32
            };
            let cost = |cell: usize| match noise(cell) % 7 {
                0 => f64::INFINITY,
                noise => 0.8 + noise as f64 * 0.7,
            };
            let map = CostMap::new(Arc::new(Surface::flat(lattice)), (0..400).map(cost).collect());
            let goal = Goal { at: Point::new(to.0, to.1), radius_m };
            let trip = Trip { start: Point::new(from.0, from.1), goal };
            if let Some(route) = ett_exact(&map, &trip, 0.0) {
                let bound = lower_bound(&map, &trip);
                prop_assert!(bound <= route.cost + 1e-9, "{} above {}", bound, route.cost);
            }
        }
    }
}
