//! Rules for which cells are sand, and sand masks from raster files.

use std::path::Path;

use contract::{Cell, Grid, Range};

use crate::{LayerNotes, SourceCells, TerrainError, read_layer};

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
    /// If the file cannot be read, has another shape than `source`, lies elsewhere, or if what is sand may as well be nodata.
    pub fn read_mask(path: &Path, source: &SourceCells) -> Result<(Vec<bool>, LayerNotes), TerrainError> {
        let layer = read_layer(path, source)?;
        let mask: Vec<bool> = layer.values.iter().map(|value| !value.is_nan() && *value != 0.0).collect();
        // What is nodata beside other values of sand may be sand where the file has nothing but it, and 0.
        let is_alone =
            |others: Option<Range>| others.is_none_or(|others| others.min >= 0.0 && others.max <= 0.0);
        if let Some(fill) = layer
            .notes
            .fills
            .iter()
            .find(|fill| is_alone(fill.others) && (fill.value > 0.0 || fill.others.is_none()))
            && !mask.contains(&true)
        {
            let zeros = if fill.others.is_some() { " and 0" } else { "" };
            let unclear = TerrainError::Unsupported {
                what: "sand mask",
                need: "values of sand that are no usual nodata, such as 1",
                got: format!("nothing but {}{zeros}", fill.in_words()),
                remedy: "write 1 for sand: gdal_calc.py -A IN.tif --calc='A>0' --outfile OUT.tif",
            };
            return Err(unclear.of(path));
        }
        Ok((mask, layer.notes))
    }
}
