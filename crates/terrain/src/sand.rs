//! Where the ground is sand.

use std::path::Path;

use contract::{Cell, Grid};

use crate::elevation::{resample_ratio, resampled_side};
use crate::{RasterFile, TerrainError, Window};

/// Cells x.min..=x.max by y.min..=y.max.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// First and last column.
    pub x: [i32; 2],
    /// First and last row.
    pub y: [i32; 2],
}

/// Sand lies wherever one of these says so.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sand {
    /// Whole rectangles.
    pub rectangles: Vec<Rectangle>,
    /// Wherever the height above the datum is less than this, metres.
    pub below_height_m: Option<f64>,
    /// Wherever the mask of the terrain's own shape is true; empty for no mask.
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
    /// The raster has the shape `(width, height)` of the terrain's source; `window` is cut from it as
    /// it was from the source, and if the source was resampled by `ratio` (new cell over old), each new
    /// cell takes the old one its middle lies in.
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
