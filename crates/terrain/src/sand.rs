//! Rules for which cells are sand, and sand masks from raster files.

use std::path::Path;

use contract::{Cell, Grid};

use crate::elevation::{resample_ratio, resampled_side};
use crate::{RasterFile, TerrainError, Window};

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

    /// Reads a mask from the raster at `path`: sand where its value is neither 0 nor nodata.
    ///
    /// The raster needs the shape `(width, height)` of the terrain's source. It is cropped to `window` as the
    /// source was. If the source was resampled by `ratio` (new cell size over old), each new cell takes the
    /// value of the old cell that its middle lies in.
    ///
    /// # Errors
    /// If the file cannot be read or has another shape.
    pub fn read_mask(
        path: &Path,
        (width, height): (u32, u32),
        window: Window,
        ratio: Option<f64>,
    ) -> Result<Vec<bool>, TerrainError> {
        let mut raster = RasterFile::open(path)?;
        let (got_width, got_height) = (raster.header().width, raster.header().height);
        if (got_width, got_height) != (width, height) {
            let shape =
                TerrainError::MaskShape { need_width: width, need_height: height, got_width, got_height };
            return Err(shape.of(path));
        }
        let mask = raster.values(window).map_err(|error| error.of(path))?;
        let sand = |value: f64| !value.is_nan() && value != 0.0;
        let Some(ratio) = ratio else { return Ok(mask.into_iter().map(sand).collect()) };
        let ratio = resample_ratio(1.0, ratio)?;
        let (columns, rows) = (resampled_side(window.width, ratio)?, resampled_side(window.height, ratio)?);
        let nearest =
            |cell: u32, side: u32| (((f64::from(cell) + 0.5) * ratio) as u32).min(side - 1) as usize;
        Ok((0..rows)
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .map(|(x, y)| {
                sand(mask[nearest(y, window.height) * window.width as usize + nearest(x, window.width)])
            })
            .collect())
    }
}
