//! The exact cells of a straight line (Amanatides & Woo 1987, "A fast voxel traversal algorithm for ray tracing").

use std::ops::ControlFlow;

use crate::{Lattice, Point};

/// A straight way from one point to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where it begins.
    pub from: Point,
    /// Where it ends.
    pub to: Point,
}

impl Segment {
    /// The segments from point to point of a way; none for less than two points.
    pub fn along(points: &[Point]) -> impl DoubleEndedIterator<Item = Self> + '_ {
        points.windows(2).map(|pair| Self { from: pair[0], to: pair[1] })
    }
}

/// Pieces shorter than this, in metres, are rounding errors at cell corners and count for the next cell.
pub const SLIVER_M: f64 = 1e-9;

/// The crossings of the cell borders of one axis.
struct Axis {
    /// Share of the segment at the next crossing; infinite after the last one.
    next: f64,
    /// Borders that are still to be crossed.
    left: usize,
    border: f64,
    origin: f64,
    inverse: f64,
    step: f64,
}

impl Axis {
    #[inline]
    fn new(from: f64, to: f64, cells: usize) -> (usize, Self) {
        let first = (from as usize).min(cells - 1);
        let last = (to as usize).min(cells - 1);
        let (border, step) = if to > from { (first as f64 + 1.0, 1.0) } else { (first as f64, -1.0) };
        let inverse = 1.0 / (to - from);
        let mut axis =
            Self { next: f64::INFINITY, left: first.abs_diff(last), border, origin: from, inverse, step };
        axis.look_ahead();
        (first, axis)
    }

    #[inline]
    fn look_ahead(&mut self) {
        self.next = if self.left == 0 { f64::INFINITY } else { (self.border - self.origin) * self.inverse };
    }

    #[inline]
    fn cross(&mut self) {
        self.border += self.step;
        self.left -= 1;
        self.look_ahead();
    }
}

/// Calls `visit` with each cell that the segment crosses and its length there on the plane, in order.
///
/// The lengths sum to the segment's. A segment through a corner does not enter the two cells beside it; one along a border runs
/// in the cell to the east or north. Points beyond the border of the map count as in the outermost cell.
#[inline]
pub fn traverse<B>(
    lattice: Lattice,
    segment: Segment,
    mut visit: impl FnMut(usize, f64) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let Segment { from, to } = segment;
    let length_m = from.distance_m(to);
    let width = lattice.width();
    let (column, mut x) = Axis::new(from.x_m, to.x_m, width);
    let (row, mut y) = Axis::new(from.y_m, to.y_m, lattice.height());
    let mut cell = row * width + column;
    let mut done = 0.0;
    loop {
        let next = x.next.min(y.next).min(1.0);
        let piece_m = (next - done) * length_m;
        if piece_m > SLIVER_M {
            visit(cell, piece_m)?;
            done = next;
        }
        if next >= 1.0 {
            return ControlFlow::Continue(());
        }
        if x.next <= next {
            cell = if x.step > 0.0 { cell + 1 } else { cell - 1 };
            x.cross();
        }
        if y.next <= next {
            cell = if y.step > 0.0 { cell + width } else { cell - width };
            y.cross();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pieces(from: (f64, f64), to: (f64, f64)) -> Vec<(usize, f64)> {
        let lattice = Lattice::new(40, 30).unwrap();
        let mut pieces = Vec::new();
        let segment = Segment { from: Point::new(from.0, from.1), to: Point::new(to.0, to.1) };
        let _ = traverse(lattice, segment, |cell, length_m| {
            pieces.push((cell, length_m));
            ControlFlow::<()>::Continue(())
        });
        pieces
    }

    #[test]
    fn a_diagonal_through_corners_enters_no_cell_beside_it() {
        let cells: Vec<usize> = pieces((0.5, 0.5), (3.5, 3.5)).iter().map(|piece| piece.0).collect();
        assert_eq!(cells, [0, 41, 82, 123]);
    }

    #[test]
    fn a_knights_move_has_a_quarter_of_its_length_in_each_of_four_cells() {
        let quarter = 5_f64.sqrt() / 4.0;
        let expected = [(0, quarter), (1, quarter), (41, quarter), (42, quarter)];
        assert_eq!(pieces((0.5, 0.5), (2.5, 1.5)), expected);
    }

    #[test]
    fn a_westward_segment_from_a_border_begins_in_the_western_cell() {
        assert_eq!(pieces((3.0, 0.5), (1.5, 0.5)), [(2, 1.0), (1, 0.5)]);
        assert_eq!(pieces((40.0, 0.5), (38.5, 0.5)), [(39, 1.0), (38, 0.5)]);
    }

    proptest! {
        /// P-TRAVERSE: The cells of a segment are exact: planner and drive cut a path into the same
        /// pieces, whose lengths sum to that of the path.
        #[test]
        fn traversal_lengths_sum_to_the_segments_length_over_touching_cells(
            from in (0.0..=40.0_f64, 0.0..=30.0_f64), to in (0.0..=40.0_f64, 0.0..=30.0_f64),
        ) {
            let pieces = pieces(from, to);
            let length_m = Point::new(from.0, from.1).distance_m(Point::new(to.0, to.1));
            let sum_m: f64 = pieces.iter().map(|piece| piece.1).sum();
            prop_assert!((sum_m - length_m).abs() < 2.0 * SLIVER_M, "{sum_m} against {length_m}");
            for pair in pieces.windows(2) {
                let (a, b) = (pair[0].0, pair[1].0);
                let (columns, rows) = ((a % 40).abs_diff(b % 40), (a / 40).abs_diff(b / 40));
                prop_assert!(columns <= 1 && rows <= 1 && columns + rows > 0);
            }
        }

        /// The middle of each piece lies in the cell that the piece is counted for.
        #[test]
        fn each_piece_lies_in_its_cell(
            from in (0.0..=40.0_f64, 0.0..=30.0_f64), to in (0.0..=40.0_f64, 0.0..=30.0_f64),
        ) {
            let (a, b) = (Point::new(from.0, from.1), Point::new(to.0, to.1));
            let mut at_m = 0.0;
            for (cell, length_m) in pieces(from, to) {
                let middle = a.towards(b, (at_m + length_m / 2.0) / a.distance_m(b));
                if length_m > 1e-6 {
                    prop_assert_eq!(Lattice::new(40, 30).unwrap().cell(middle), cell);
                }
                at_m += length_m;
            }
        }
    }
}
