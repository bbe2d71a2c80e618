//! Heights on a square lattice, as read from an elevation model.

use contract::Grid;

use crate::{TerrainError, Window};

/// Absolute heights, row-major, southernmost row first; NaN where there is no data.
#[derive(Clone, Debug, PartialEq)]
pub struct Elevation {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// `width` × `height` heights, metres above the reference of the file.
    pub heights_m: Vec<f64>,
}

impl Elevation {
    /// The same ground resampled to cells of `cell_size_m`. The south-western corner stays; cells that do not
    /// fit whole at the northern and eastern edges are left out. Heights are interpolated bilinearly between
    /// the middles of the old cells; within half a cell of the edge the outermost height is used. If any old
    /// cell with weight is nodata, the new one is nodata.
    ///
    /// # Errors
    /// If the cell size is not above 0 m, or the result exceeds the bounds of a [`Grid`].
    pub fn resampled(&self, cell_size_m: f64) -> Result<Self, TerrainError> {
        let (columns, rows) = (self.axis(self.width, cell_size_m)?, self.axis(self.height, cell_size_m)?);
        let mut heights_m = Vec::with_capacity(columns.len() * rows.len());
        for y in &rows {
            for x in &columns {
                let mut sum = 0.0;
                for (row, row_weight) in y.neighbours() {
                    for (column, column_weight) in x.neighbours() {
                        // NaN times 0 is NaN: a neighbour without weight must not be read.
                        if row_weight * column_weight > 0.0 {
                            let height = self.heights_m[row * self.width as usize + column];
                            sum += row_weight * column_weight * height;
                        }
                    }
                }
                heights_m.push(sum);
            }
        }
        Ok(Self { width: columns.len() as u32, height: rows.len() as u32, cell_size_m, heights_m })
    }

    /// The cells of `window`, row by row.
    ///
    /// # Panics
    /// If the window is not within the raster.
    pub fn rows(&self, window: Window) -> impl Iterator<Item = &[f64]> {
        (window.y..window.y + window.height).map(move |y| {
            let start = y as usize * self.width as usize + window.x as usize;
            &self.heights_m[start..start + window.width as usize]
        })
    }

    fn axis(&self, side: u32, cell_size_m: f64) -> Result<Vec<Interpolation>, TerrainError> {
        let ratio = resample_ratio(self.cell_size_m, cell_size_m)?;
        let cells = resampled_side(side, ratio)?;
        Ok((0..cells).map(|cell| Interpolation::new((f64::from(cell) + 0.5) * ratio - 0.5, side)).collect())
    }
}

/// Size of a new cell in units of an old one.
pub(crate) fn resample_ratio(old_m: f64, new_m: f64) -> Result<f64, TerrainError> {
    let ratio = new_m / old_m;
    if ratio.is_finite() && ratio > 0.0 {
        Ok(ratio)
    } else {
        Err(TerrainError::Value { what: "cell_size_m", need: "a length above 0 m", got: new_m })
    }
}

/// Number of whole new cells along a side of `side` old ones, checked against the bounds of a grid before
/// anything of that size is allocated.
pub(crate) fn resampled_side(side: u32, ratio: f64) -> Result<u32, TerrainError> {
    // Tolerates rounding: an exact multiple must not lose a cell in the division.
    let cells = (f64::from(side) / ratio * (1.0 + 1e-12)).floor().min(f64::from(u32::MAX)) as u32;
    Grid::new(cells, 1, 1.0, 1)?;
    Ok(cells)
}

/// The two cells of an axis between which a position lies.
struct Interpolation {
    low: usize,
    high: usize,
    /// Weight of `high`, 0 to 1.
    share: f64,
}

impl Interpolation {
    fn new(position: f64, side: u32) -> Self {
        let position = position.clamp(0.0, f64::from(side - 1));
        let low = position.floor() as usize;
        Self { low, high: (low + 1).min(side as usize - 1), share: position - low as f64 }
    }

    fn neighbours(&self) -> [(usize, f64); 2] {
        [(self.low, 1.0 - self.share), (self.high, self.share)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(width: u32, height: u32, cell_size_m: f64) -> Elevation {
        let heights_m = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| 3.0 * (f64::from(x) + 0.5) * cell_size_m - (f64::from(y) + 0.5) * cell_size_m)
            .collect();
        Elevation { width, height, cell_size_m, heights_m }
    }

    #[test]
    fn resampling_a_plane_gives_the_plane_away_from_the_edge() {
        let old = plane(20, 12, 2.0);
        for size in [0.5, 1.0, 3.0, 4.0] {
            let (new, exact) = (old.resampled(size).unwrap(), plane(40, 24, 1.0).resampled(1.0).unwrap());
            assert_eq!(exact, plane(40, 24, 1.0), "the same cell size changes nothing");
            assert_eq!(new.width, (40.0 / size) as u32);
            assert_eq!(new.height, (24.0 / size) as u32);
            for y in 0..new.height {
                for x in 0..new.width {
                    let [east, north] = [x, y].map(|i| (f64::from(i) + 0.5) * size);
                    if (1.0..=39.0).contains(&east) && (1.0..=23.0).contains(&north) {
                        let height = new.heights_m[(y * new.width + x) as usize];
                        assert!(
                            (height - (3.0 * east - north)).abs() < 1e-9,
                            "({x}, {y}) at {size} m: {height}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_neighbour_without_height_makes_none_unless_it_weighs_nothing() {
        let mut old = plane(4, 4, 1.0);
        old.heights_m[5] = f64::NAN;
        assert_eq!(old.resampled(1.0).unwrap().heights_m.iter().filter(|h| h.is_nan()).count(), 1);
        let fine = old.resampled(0.5).unwrap();
        assert!(fine.heights_m[2 * 8 + 2].is_nan() && !fine.heights_m[0].is_nan());
    }

    #[test]
    fn cells_too_small_too_large_or_of_no_size_are_refused_before_memory_is_taken() {
        let old = plane(20, 20, 1.0);
        for size in [1e-9, 100.0, 0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(old.resampled(size).is_err(), "{size}");
        }
    }
}
