//! What a raster file says of itself before its cells are read, whatever its format.

use serde::Serialize;

/// Most cells that are read at once: 128 MiB of heights.
pub const ELEVATION_CELLS_MAX: u64 = 1 << 24;

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RasterFormat {
    /// TIFF with geo tags (OGC 19-008).
    Geotiff,
    /// ESRI ASCII grid.
    AsciiGrid,
}

/// What the file's coordinates point at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PixelIs {
    /// A corner of a cell: its middle lies half a cell further.
    Area,
    /// The middle of a cell.
    Point,
}

/// What is known of a raster before its cells are read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RasterHeader {
    /// Format of the file.
    pub format: RasterFormat,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Type of a sample, such as `int16` or `float32`.
    pub sample: &'static str,
    /// The value that marks cells without data, if the file declares one.
    pub nodata: Option<f64>,
    /// Stored values are multiplied by this ...
    pub scale: f64,
    /// ... and this is added, to give metres.
    pub offset: f64,
}

/// Middle of the north-western cell and the cell's sides, in the file's unit.
pub(crate) struct Placement {
    pub x_size: f64,
    pub y_size: f64,
    pub west: f64,
    pub north: f64,
    pub pixel_is: PixelIs,
}
