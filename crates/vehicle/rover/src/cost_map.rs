//! The cost of ways: an integral over the cells that they cross.

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::{Lattice, Point, Segment, Surface, traverse};

/// A cost per metre for each cell: Sol for the planners of travel time, metres for the naive one. Infinite is forbidden.
#[derive(Clone, Debug)]
pub struct CostMap {
    surface: Arc<Surface>,
    costs: Vec<f64>,
    least: f64,
    most: f64,
}

impl CostMap {
    /// The map with these costs per metre on the ground, in the order of the cells.
    ///
    /// # Panics
    /// If there are not as many as cells, or one of them is not positive.
    #[must_use]
    pub fn new(surface: Arc<Surface>, costs: Vec<f64>) -> Self {
        assert_eq!(costs.len(), surface.lattice().cells(), "a cost map needs a cost for each cell");
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for cost in &costs {
            assert!(*cost > 0.0, "a cost per metre needs to be positive, got {cost}");
            if *cost < f64::INFINITY {
                least = least.min(*cost);
                most = most.max(*cost);
            }
        }
        Self { surface, costs, least, most }
    }

    /// The cells of the map.
    #[must_use]
    pub fn lattice(&self) -> Lattice {
        self.surface.lattice()
    }

    /// The shape of the ground.
    #[must_use]
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// Cost per metre of each cell.
    #[must_use]
    pub fn costs(&self) -> &[f64] {
        &self.costs
    }

    /// The least cost per metre: times a distance, no way is cheaper. Infinite if everything is forbidden.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.least
    }

    /// The greatest finite cost per metre; 0 if everything is forbidden.
    #[must_use]
    pub fn most(&self) -> f64 {
        self.most
    }

    /// The cost of a segment; infinite if it crosses a forbidden cell or costs more than `limit`.
    #[must_use]
    #[inline]
    pub fn within(&self, segment: Segment, limit: f64) -> f64 {
        let mut sum = 0.0;
        let flow = self.pieces(segment, |cost, _| {
            sum += cost;
            if sum > limit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if flow.is_break() { f64::INFINITY } else { sum }
    }

    /// The cost of a segment; infinite if it crosses a forbidden cell.
    #[must_use]
    pub fn segment(&self, segment: Segment) -> f64 {
        // Below infinity, so that a forbidden cell ends the sum.
        self.within(segment, f64::MAX)
    }

    /// The cost of a way through `points`; 0 for less than two.
    #[must_use]
    pub fn way(&self, points: &[Point]) -> f64 {
        Segment::along(points).map(|segment| self.segment(segment)).sum()
    }

    /// How far along a segment the cost `limit` reaches: its end, or a point before.
    #[must_use]
    pub fn reach(&self, segment: Segment, limit: f64) -> Point {
        let length_m = segment.from.distance_m(segment.to);
        let (mut sum, mut done_m) = (0.0, 0.0);
        let flow = self.pieces(segment, |cost, piece_m| {
            if sum + cost > limit {
                // A forbidden piece is not entered at all.
                return ControlFlow::Break(done_m + piece_m * ((limit - sum) / cost));
            }
            sum += cost;
            done_m += piece_m;
            ControlFlow::Continue(())
        });
        match flow {
            ControlFlow::Break(at_m) => segment.from.towards(segment.to, at_m / length_m),
            ControlFlow::Continue(()) => segment.to,
        }
    }

    /// Calls `visit` with the cost of each piece and its length on the plane.
    #[inline]
    fn pieces<B>(
        &self,
        segment: Segment,
        mut visit: impl FnMut(f64, f64) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        if self.surface.is_flat() {
            return traverse(self.lattice(), segment, |cell, piece_m| {
                visit(self.costs[cell] * piece_m, piece_m)
            });
        }
        let direction = segment.direction();
        traverse(self.lattice(), segment, |cell, piece_m| {
            visit(self.costs[cell] * piece_m * self.surface.stretch(cell, direction), piece_m)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// 20 x 20 cells with costs 1 to 5 on bumpy ground, made of a number.
    fn map(seed: u64) -> CostMap {
        let lattice = Lattice::new(20, 20).unwrap();
        let noise =
            |cell: usize| (cell as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let heights_m: Vec<f64> = (0..400).map(|cell| (noise(cell) % 100) as f64 / 100.0).collect();
        let surface = Surface::from_heights(lattice, &heights_m).unwrap();
        CostMap::new(Arc::new(surface), (0..400).map(|cell| 1.0 + (noise(cell) % 5) as f64).collect())
    }

    #[test]
    fn a_forbidden_cell_makes_a_way_infinite_and_is_not_reached() {
        let surface = Arc::new(Surface::flat(Lattice::new(4, 1).unwrap()));
        let map = CostMap::new(surface, vec![1.0, 2.0, f64::INFINITY, 1.0]);
        let segment = Segment { from: Point::new(0.0, 0.5), to: Point::new(4.0, 0.5) };
        assert_eq!(map.segment(segment), f64::INFINITY);
        assert_eq!(map.reach(segment, 2.0), Point::new(1.5, 0.5));
        assert_eq!(map.reach(segment, 100.0), Point::new(2.0, 0.5));
        assert_eq!(map.segment(Segment { to: Point::new(2.0, 0.5), ..segment }), 3.0);
        assert_eq!((map.least(), map.most()), (1.0, 2.0));
    }

    proptest! {
        #[test]
        fn the_integral_along_a_route_is_the_sum_over_its_pieces(
            seed in any::<u64>(), share in 0.0..=1.0_f64,
            from in (0.0..=20.0_f64, 0.0..=20.0_f64), to in (0.0..=20.0_f64, 0.0..=20.0_f64),
        ) {
            let map = map(seed);
            let (from, to) = (Point::new(from.0, from.1), Point::new(to.0, to.1));
            let middle = from.towards(to, share);
            let (whole, cut) = (map.way(&[from, to]), map.way(&[from, middle, to]));
            prop_assert!((whole - cut).abs() < 1e-6 * (1.0 + whole), "{whole} against {cut}");
            prop_assert!(whole >= map.least() * from.distance_m(to) - 1e-9);
        }

        #[test]
        fn reach_ends_where_the_cost_is_used_up(
            seed in any::<u64>(), limit in 0.1..100.0_f64,
            from in (0.0..=20.0_f64, 0.0..=20.0_f64), to in (0.0..=20.0_f64, 0.0..=20.0_f64),
        ) {
            let map = map(seed);
            let segment = Segment { from: Point::new(from.0, from.1), to: Point::new(to.0, to.1) };
            let end = map.reach(segment, limit);
            let cost = map.segment(Segment { to: end, ..segment });
            let expected = map.segment(segment).min(limit);
            prop_assert!((cost - expected).abs() < 1e-6, "{cost} against {expected}");
        }
    }
}
