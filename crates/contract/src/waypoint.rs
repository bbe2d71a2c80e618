//! Points of the map in metres.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{Cell, Grid};

/// A point of the map in metres: x grows eastwards, y northwards, (0, 0) is the south-western corner of cell (0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Waypoint {
    /// Eastwards, metres.
    pub x_m: f64,
    /// Northwards, metres.
    pub y_m: f64,
}

impl Waypoint {
    /// Straight distance on the plane, metres.
    #[must_use]
    pub fn distance_m(self, other: Self) -> f64 {
        let (dx, dy) = (other.x_m - self.x_m, other.y_m - self.y_m);
        (dx * dx + dy * dy).sqrt()
    }

    /// Distance to the nearest point of the straight leg between two points, metres.
    #[must_use]
    pub fn distance_to_leg_m(self, from: Self, to: Self) -> f64 {
        let (dx, dy) = (to.x_m - from.x_m, to.y_m - from.y_m);
        let squared = dx * dx + dy * dy;
        let along = (self.x_m - from.x_m) * dx + (self.y_m - from.y_m) * dy;
        let share = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
        self.distance_m(Self { x_m: from.x_m + share * dx, y_m: from.y_m + share * dy })
    }

    /// The middle of `cell`.
    #[must_use]
    pub fn middle_of(grid: &Grid, cell: Cell) -> Self {
        let metres = |cells: i32| (f64::from(cells) + 0.5) * grid.cell_size_m;
        Self { x_m: metres(cell.x), y_m: metres(cell.y) }
    }

    /// The cell that it lies in, possibly outside of the grid; on a border, the one to the east or north.
    #[must_use]
    pub fn cell_of(self, grid: &Grid) -> Cell {
        let cells = |metres: f64| (metres / grid.cell_size_m).floor() as i32;
        Cell { x: cells(self.x_m), y: cells(self.y_m) }
    }
}

impl fmt::Display for Waypoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:.3}, {:.3}) m", self.x_m, self.y_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_a_leg_is_that_to_its_nearest_point() {
        let at = |x_m, y_m| Waypoint { x_m, y_m };
        let leg = (at(0.0, 0.0), at(4.0, 0.0));
        for (point, need_m) in
            [(at(1.0, 2.0), 2.0), (at(-3.0, 4.0), 5.0), (at(7.0, -4.0), 5.0), (at(2.0, 0.0), 0.0)]
        {
            assert_eq!(point.distance_to_leg_m(leg.0, leg.1), need_m, "{point}");
        }
        assert_eq!(at(3.0, 4.0).distance_to_leg_m(leg.0, leg.0), 5.0);
    }

    #[test]
    fn a_cell_has_its_middle_and_its_western_and_southern_border() {
        let grid = Grid::new(9, 9, 0.5, 2).unwrap();
        let middle = Waypoint::middle_of(&grid, Cell::new(2, 0));
        assert_eq!((middle.x_m, middle.y_m), (1.25, 0.25));
        for (x_m, x) in [(1.25, 2), (1.0, 2), (0.999, 1), (-0.1, -1), (4.5, 9)] {
            assert_eq!(Waypoint { x_m, y_m: 0.25 }.cell_of(&grid), Cell::new(x, 0), "{x_m} m");
        }
    }
}
