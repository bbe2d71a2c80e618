//! The cells that a sensor shows around a robot.

use crate::{Cell, Grid};

/// Cells around that of a robot: those at most so many columns and rows away whose middle is near enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Columns and rows to each side.
    side: i32,
    /// Farthest middle of a cell, cells.
    radius_cells: f64,
}

impl View {
    /// The closed disc of that radius, cells.
    #[must_use]
    pub fn disc(radius_cells: f64) -> Self {
        Self { side: radius_cells as i32, radius_cells }
    }

    /// The square that reaches so many cells to each side.
    #[must_use]
    pub fn square(side: u32) -> Self {
        Self { side: i32::try_from(side).unwrap_or(i32::MAX), radius_cells: f64::INFINITY }
    }

    /// These cells of `grid` around `centre`, in index order. Outside of the grid there is nothing to see.
    pub fn cells(self, grid: Grid, centre: Cell) -> impl Iterator<Item = Cell> + use<> {
        // Clipped before it is walked: a sensor may see further than any grid is wide.
        let side = if grid.contains(centre) { self.side } else { -1 };
        let clip = |at: i32, sides: u32| {
            at.saturating_sub(side).max(0)..=at.saturating_add(side).min(sides as i32 - 1)
        };
        let (columns, rows) = (clip(centre.x, grid.width), clip(centre.y, grid.height));
        rows.flat_map(move |y| columns.clone().map(move |x| Cell::new(x, y)))
            .filter(move |cell| cell.distance_cells(centre) <= self.radius_cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(x: i32, y: i32, radius_cells: f64) -> usize {
        View::disc(radius_cells).cells(Grid::new(20, 20, 1.0, 1).unwrap(), Cell::new(x, y)).count()
    }

    #[test]
    fn a_disc_of_two_cells_is_closed_and_holds_thirteen_cells() {
        assert_eq!(seen(10, 10, 2.0), 13);
        assert_eq!(seen(10, 10, 1.98), 9, "just below two cells the four far cells are out of sight");
        assert_eq!(seen(0, 0, 2.0), 6, "a corner sees a quarter of the disc");
        assert_eq!(seen(-1, 5, 2.0), 0, "outside the map there is nothing to see");
        let far = View::disc(1e6);
        let grid = Grid::new(1000, 1000, 1.0, 1).unwrap();
        assert_eq!(far.cells(grid, Cell::new(3, 4)).count(), 1_000_000);
    }

    #[test]
    fn a_square_of_one_cell_has_nine_cells_and_is_clipped_at_the_border() {
        let grid = Grid::new(5, 4, 1.0, 1).unwrap();
        let cells = |side, x, y| View::square(side).cells(grid, Cell::new(x, y)).collect::<Vec<_>>();
        assert_eq!(cells(1, 2, 2).len(), 9);
        assert_eq!(cells(1, 0, 0), [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| Cell::new(x, y)));
        assert_eq!(cells(2, 4, 3).len(), 9);
        assert_eq!(cells(64, 2, 2).len(), 20);
    }
}
