//! Ways that keep a distance from forbidden cells.

use std::ops::ControlFlow;

use rover::{CostMap, Lattice, Point, Segment, traverse};

use crate::Trip;

/// Distances that are short of the clearance by less than this keep it, metres.
const TOLERANCE_M: f64 = 1e-9;

/// A cost map on which ways keep clear of forbidden cells.
///
/// Forbidden cells that are nearer than the clearance to where a trip begins or to the middle of its goal are only not entered.
/// The border of the map is no forbidden cell.
#[derive(Debug)]
pub struct KeptClear<'a> {
    costs: &'a CostMap,
    clearance_m: f64,
    /// Whether a forbidden cell is so near that a way through the cell may be too near to it.
    is_near: Vec<bool>,
    /// Forbidden cells that need not be kept clear of.
    exempt: Vec<usize>,
}

impl<'a> KeptClear<'a> {
    /// The map without a clearance.
    #[must_use]
    pub fn none(costs: &'a CostMap) -> Self {
        Self { costs, clearance_m: 0.0, is_near: Vec::new(), exempt: Vec::new() }
    }

    /// The map for a trip, with a clearance of 0 or more.
    #[must_use]
    pub fn new(costs: &'a CostMap, trip: &Trip, clearance_m: f64) -> Self {
        let mut kept = Self { clearance_m: clearance_m.max(0.0), ..Self::none(costs) };
        if clearance_m <= 0.0 {
            return kept;
        }
        let lattice = costs.lattice();
        let rings = clearance_m.ceil() as usize;
        let ends = [trip.start, trip.goal.at].map(|at| Segment { from: at, to: at });
        let around_end =
            |end: Segment| around(lattice, lattice.cell(end.from), rings).map(move |cell| (end, cell));
        let near = ends.into_iter().flat_map(around_end).filter(|(end, cell)| kept.is_too_near(*end, *cell));
        kept.exempt = near.map(|(_, cell)| cell).collect();
        kept.is_near = widened(costs, rings);
        kept
    }

    /// The costs, whatever is kept clear of.
    #[must_use]
    pub fn costs(&self) -> &CostMap {
        self.costs
    }

    /// The cost of a segment; infinite if it crosses a forbidden cell or comes too near to one.
    #[must_use]
    pub fn segment(&self, segment: Segment) -> f64 {
        self.within(segment, f64::MAX)
    }

    /// The cost of a way through `points`; 0 for less than two.
    #[must_use]
    pub fn way(&self, points: &[Point]) -> f64 {
        Segment::along(points).map(|segment| self.segment(segment)).sum()
    }

    /// [`KeptClear::segment`]; infinite too if it costs more than `limit`.
    pub(crate) fn within(&self, segment: Segment, limit: f64) -> f64 {
        let cost = self.costs.within(segment, limit);
        if cost < f64::INFINITY && !self.is_clear(segment) { f64::INFINITY } else { cost }
    }

    fn is_clear(&self, segment: Segment) -> bool {
        if self.clearance_m <= 0.0 {
            return true;
        }
        let lattice = self.costs.lattice();
        let rings = self.clearance_m.ceil() as usize;
        let flow = traverse(lattice, segment, |cell, _| {
            let mut around = around(lattice, cell, rings);
            if self.is_near[cell] && around.any(|cell| self.is_too_near(segment, cell)) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        flow.is_continue()
    }

    /// Whether a cell is forbidden, and no way may come near to it.
    pub(crate) fn is_kept_from(&self, cell: usize) -> bool {
        self.costs.costs()[cell] == f64::INFINITY && !self.exempt.contains(&cell)
    }

    /// Whether a distance is short of the clearance.
    pub(crate) fn is_closer(&self, distance_m: f64) -> bool {
        distance_m < self.clearance_m - TOLERANCE_M
    }

    fn is_too_near(&self, segment: Segment, cell: usize) -> bool {
        self.is_kept_from(cell) && self.is_closer(distance_m(segment, corner(self.costs.lattice(), cell)))
    }
}

/// The cells within so many rings around `cell`, itself included.
fn around(lattice: Lattice, cell: usize, rings: usize) -> impl Iterator<Item = usize> {
    let (width, height) = (lattice.width(), lattice.height());
    let (column, row) = (cell % width, cell / width);
    let rows = row.saturating_sub(rings)..=(row + rings).min(height - 1);
    let columns = column.saturating_sub(rings)..=(column + rings).min(width - 1);
    rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// Whether a forbidden cell is within so many rings, by cell.
fn widened(costs: &CostMap, rings: usize) -> Vec<bool> {
    let (width, height) = (costs.lattice().width(), costs.lattice().height());
    let forbidden = costs.costs().iter().enumerate().filter(|(_, cost)| **cost == f64::INFINITY);
    let mut along_rows = vec![false; width * height];
    for (cell, _) in forbidden {
        let (column, first) = (cell % width, cell - cell % width);
        along_rows[first + column.saturating_sub(rings)..=first + (column + rings).min(width - 1)].fill(true);
    }
    let mut near = vec![false; width * height];
    for row in 0..height {
        for from in row.saturating_sub(rings)..=(row + rings).min(height - 1) {
            let (to, from) = (&mut near[row * width..][..width], &along_rows[from * width..][..width]);
            to.iter_mut().zip(from).for_each(|(to, from)| *to |= from);
        }
    }
    near
}

/// The corner of a cell with the least coordinates.
fn corner(lattice: Lattice, cell: usize) -> Point {
    Point::new((cell % lattice.width()) as f64, (cell / lattice.width()) as f64)
}

/// Distance from a segment to the square metre that has `corner` as its least one.
pub(crate) fn distance_m(segment: Segment, corner: Point) -> f64 {
    let Segment { from, to } = segment;
    let (dx, dy) = (to.x_m - from.x_m, to.y_m - from.y_m);
    // The part of the segment within the square (Liang & Barsky 1984).
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    let mut meets = true;
    for (at, step, low) in [(from.x_m, dx, corner.x_m), (from.y_m, dy, corner.y_m)] {
        if step == 0.0 {
            meets &= (low..=low + 1.0).contains(&at);
        } else {
            let (a, b) = ((low - at) / step, (low + 1.0 - at) / step);
            enters = enters.max(a.min(b));
            leaves = leaves.min(a.max(b));
        }
    }
    if meets && enters <= leaves {
        return 0.0;
    }
    let to_square = |at: Point| {
        let beyond = |at: f64, low: f64| (low - at).max(at - low - 1.0).max(0.0);
        libm::hypot(beyond(at.x_m, corner.x_m), beyond(at.y_m, corner.y_m))
    };
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    let to_segment = |(x, y): (f64, f64)| {
        let at = Point::new(corner.x_m + x, corner.y_m + y);
        let length_2 = dx * dx + dy * dy;
        let along = if length_2 > 0.0 {
            (((at.x_m - from.x_m) * dx + (at.y_m - from.y_m) * dy) / length_2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        at.distance_m(Point::new(from.x_m + along * dx, from.y_m + along * dy))
    };
    let of_corners = corners.into_iter().map(to_segment).fold(f64::INFINITY, f64::min);
    to_square(from).min(to_square(to)).min(of_corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_segments_to_a_square() {
        let square = Point::new(2.0, 3.0);
        let far = |from: (f64, f64), to: (f64, f64)| {
            distance_m(Segment { from: Point::new(from.0, from.1), to: Point::new(to.0, to.1) }, square)
        };
        assert_eq!(far((0.0, 3.5), (5.0, 3.5)), 0.0, "through it");
        assert_eq!(far((0.0, 3.0), (5.0, 3.0)), 0.0, "along its edge");
        assert_eq!(far((0.0, 2.5), (5.0, 2.5)), 0.5, "past its edge");
        assert_eq!(far((1.5, 3.2), (1.5, 3.2)), 0.5, "a point");
        assert!((far((0.0, 4.0), (2.0, 2.0)) - 0.5_f64.sqrt()).abs() < 1e-12, "past a corner, aslant");
        assert_eq!(far((6.0, 8.0), (7.0, 8.0)), 5.0, "to the nearer end");
        assert_eq!(far((2.2, 3.2), (2.4, 3.6)), 0.0, "within it");
    }
}
