//! Elevations and gradients on a square lattice, before a datum and soils are applied.

use contract::{Cell, Grid};

use crate::{Elevation, Gaussian, TerrainError};

/// Elevation and gradient of every cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Lattice of the cells.
    pub grid: Grid,
    /// Cells in index order: absolute height in metres with the gradient (∂h/∂x, ∂h/∂y) in metres per metre;
    /// `None` where the data has none.
    pub cells: Vec<Option<(f64, [f64; 2])>>,
}

impl Relief {
    /// The sum of `hills`, heights and analytic gradients at the cells' coordinates: cell (x, y) lies
    /// at (x, y) times the cell size.
    #[must_use]
    pub fn of_gaussians(grid: Grid, hills: &[Gaussian]) -> Self {
        Self::of_gaussians_within(grid, hills, f64::INFINITY)
    }

    /// [`Relief::of_gaussians`] with each hill cut off `reach_sigma` standard deviations from its centre along
    /// an axis, which saves most of the work on large maps.
    #[must_use]
    pub fn of_gaussians_within(grid: Grid, hills: &[Gaussian], reach_sigma: f64) -> Self {
        let mut cells = vec![(0.0, [0.0, 0.0]); grid.cells()];
        for hill in hills {
            let reach_m = reach_sigma * hill.sigma_m;
            let clip = |centre_m: f64, side: u32| {
                let first = ((centre_m - reach_m) / grid.cell_size_m).ceil().max(0.0);
                let last = ((centre_m + reach_m) / grid.cell_size_m).floor().min(f64::from(side) - 1.0);
                // Casts saturate: a hill off the map gives an empty range.
                first as i64..=last as i64
            };
            for y in clip(hill.centre_m[1], grid.height) {
                for x in clip(hill.centre_m[0], grid.width) {
                    let (height_m, [gx, gy]) =
                        hill.height_and_gradient([x, y].map(|index| index as f64 * grid.cell_size_m));
                    let cell = &mut cells[y as usize * grid.width as usize + x as usize];
                    *cell = (cell.0 + height_m, [cell.1[0] + gx, cell.1[1] + gy]);
                }
            }
        }
        Self { grid, cells: cells.into_iter().map(Some).collect() }
    }

    /// `elevation` times `vertical_exaggeration`, with gradients by finite differences: central ones inside,
    /// one-sided ones next to the edge and to nodata. A cell with nodata on both sides along an axis counts as
    /// unknown, since its slope is.
    ///
    /// # Errors
    /// If the lattice exceeds the bounds of a grid.
    pub fn of_elevation(
        elevation: &Elevation,
        vertical_exaggeration: f64,
        hop_cells: u32,
    ) -> Result<Self, TerrainError> {
        let Elevation { width, height, cell_size_m, .. } = *elevation;
        let grid = Grid::new(width, height, cell_size_m, hop_cells)?;
        let height_at = |cell: Cell| {
            let height = elevation.heights_m[grid.index(cell)?] * vertical_exaggeration;
            (!height.is_nan()).then_some(height)
        };
        let cells = grid
            .iter()
            .map(|cell| {
                let here = height_at(cell)?;
                let along = |dx: i32, dy: i32, side: u32| {
                    let neighbour = |sign: i32| height_at(Cell::new(cell.x + sign * dx, cell.y + sign * dy));
                    if side == 1 {
                        return Some(0.0);
                    }
                    difference(neighbour(-1), here, neighbour(1), cell_size_m)
                };
                Some((here, [along(1, 0, width)?, along(0, 1, height)?]))
            })
            .collect();
        Ok(Self { grid, cells })
    }

    /// Height and gradient of the cells that have them.
    pub fn known(&self) -> impl Iterator<Item = &(f64, [f64; 2])> {
        self.cells.iter().flatten()
    }

    /// Mean height of the known cells, metres; 0 if there is none.
    #[must_use]
    pub fn mean_height_m(&self) -> f64 {
        let (sum, count) =
            self.known().fold((0.0, 0u32), |(sum, count), (height, _)| (sum + height, count + 1));
        if count == 0 { 0.0 } else { sum / f64::from(count) }
    }
}

/// Slope along one axis from the neighbours that are known; `None` if neither is.
fn difference(before: Option<f64>, here: f64, after: Option<f64>, cell_size_m: f64) -> Option<f64> {
    match (before, after) {
        (Some(before), Some(after)) => Some((after - before) / (2.0 * cell_size_m)),
        (Some(before), None) => Some((here - before) / cell_size_m),
        (None, Some(after)) => Some((after - here) / cell_size_m),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elevation(width: u32, height: u32, at: impl Fn(f64, f64) -> f64) -> Elevation {
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let heights_m = cells.map(|(x, y)| at(f64::from(x) * 2.0, f64::from(y) * 2.0)).collect();
        Elevation { width, height, cell_size_m: 2.0, heights_m }
    }

    #[test]
    fn differences_of_a_plane_are_its_slope_everywhere() {
        let relief = Relief::of_elevation(&elevation(5, 4, |x, y| 7.0 + 0.25 * x - 0.5 * y), 1.0, 1).unwrap();
        assert!(relief.known().all(|(_, gradient)| *gradient == [0.25, -0.5]));
        let exaggerated = Relief::of_elevation(&elevation(5, 4, |x, y| 0.25 * x - 0.5 * y), 2.0, 1).unwrap();
        assert!(exaggerated.known().all(|(_, gradient)| *gradient == [0.5, -1.0]));
    }

    #[test]
    fn differences_are_central_inside_and_one_sided_at_edges_and_nodata() {
        // h = x²: central differences are exact (2x), one-sided ones are off by the cell size.
        let mut parabola = elevation(6, 1, |x, _| x * x);
        parabola.heights_m[4] = f64::NAN;
        let relief = Relief::of_elevation(&parabola, 1.0, 1).unwrap();
        let slope = |x: usize| relief.cells[x].map(|(_, gradient)| gradient[0]);
        assert_eq!(slope(0), Some(2.0), "forwards at the edge");
        assert_eq!(slope(2), Some(8.0), "central: 2x at x = 4");
        assert_eq!(slope(3), Some(10.0), "backwards before nodata");
        assert_eq!(slope(4), None, "nodata");
        assert_eq!(slope(5), None, "no neighbour at all: the slope is unknown");
    }

    #[test]
    fn a_hill_of_limited_reach_is_itself_within_it_and_nothing_beyond() {
        let grid = Grid::new(41, 41, 0.5, 1).unwrap();
        let hills = [
            Gaussian { centre_m: [10.0, 10.0], sigma_m: 1.0, amplitude_m: 1.0 },
            Gaussian { centre_m: [-1.0, 25.0], sigma_m: 2.0, amplitude_m: -0.5 },
            Gaussian { centre_m: [90.0, -50.0], sigma_m: 2.0, amplitude_m: 9.0 },
        ];
        let whole = Relief::of_gaussians(grid, &hills);
        assert_eq!(Relief::of_gaussians_within(grid, &hills, 1e3), whole);
        let near = Relief::of_gaussians_within(grid, &hills, 6.0);
        let off = whole.known().zip(near.known()).map(|(a, b)| (a.0 - b.0).abs());
        let worst = off.fold(0.0, f64::max);
        assert!(worst > 0.0 && worst < 1.6e-8, "exp(-18) of the amplitude: {worst}");
        let alone = Relief::of_gaussians_within(grid, &hills[..1], 2.0);
        let touched = |(index, cell): (usize, &Option<(f64, [f64; 2])>)| {
            (*cell != Some((0.0, [0.0, 0.0]))).then(|| grid.cell(index))
        };
        let touched: Vec<Cell> = alone.cells.iter().enumerate().filter_map(touched).collect();
        assert!(touched.iter().all(|cell| (16..=24).contains(&cell.x) && (16..=24).contains(&cell.y)));
        assert_eq!(touched.len(), 81);
    }

    #[test]
    fn gaussian_relief_is_analytic_at_cell_coordinates() {
        let grid = Grid::new(3, 3, 0.5, 1).unwrap();
        let hill = Gaussian { centre_m: [0.5, 0.5], sigma_m: 1.0, amplitude_m: 1.0 };
        let relief = Relief::of_gaussians(grid, &[hill]);
        assert_eq!(relief.cells[4], Some((1.0, [-0.0, -0.0])), "cell (1, 1) lies at (0.5, 0.5) m");
        assert_eq!(relief.cells[3].unwrap().1, hill.gradient([0.0, 0.5]));
    }
}
