//! Rules for which cells are sand, and sand masks from raster files.

use std::path::Path;

use contract::{Cell, Grid};

use crate::{SourceCells, TerrainError, read_layer};

/// A rectangle of cells, its edges included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// First and last column, from the west.
    pub x: [i32; 2],
    /// First and last row, from the south.
    pub y: [i32; 2],
}

/// Which cells are sand: those to which at least one of these rules applies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sand {
    /// Cells in any of these rectangles.
    pub rectangles: Vec<Rectangle>,
    /// Cells whose height above the datum is less than this, metres.
    pub below_height_m: Option<f64>,
    /// Cells, in index order, where the mask is true; empty for no mask.
    pub mask: Vec<bool>,
}

impl Sand {
    /// Whether `cell` of `grid`, `height_m` above the datum, is sand.
    #[must_use]
    pub fn covers(&self, grid: &Grid, cell: Cell, height_m: f64) -> bool {
        let within = |[first, last]: [i32; 2], index: i32| (first..=last).contains(&index);
        self.rectangles.iter().any(|rectangle| within(rectangle.x, cell.x) && within(rectangle.y, cell.y))
            || self.below_height_m.is_some_and(|threshold_m| height_m < threshold_m)
            || grid.index(cell).is_some_and(|index| self.mask.get(index).copied().unwrap_or(false))
    }

    /// Reads a mask from the raster at `path`: sand where its value is neither 0 nor nodata. See [`read_layer`].
    ///
    /// # Errors
    /// If the file cannot be read or has another shape than `source`.
    pub fn read_mask(path: &Path, source: &SourceCells) -> Result<Vec<bool>, TerrainError> {
        let sand = |value: f64| !value.is_nan() && value != 0.0;
        // A mask lies where the terrain does, whatever position its file names.
        let source = SourceCells { georeference: None, ..source.clone() };
        Ok(read_layer(path, &source)?.into_iter().map(sand).collect())
    }
}
