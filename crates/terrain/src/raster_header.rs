//! What a raster file says of itself before its cells are read, whatever its format.

use serde::Serialize;

/// Most cells that are read at once: 128 MiB of heights.
pub const ELEVATION_CELLS_MAX: u64 = 1 << 24;

/// File formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RasterFormat {
    /// TIFF with geo tags (OGC 19-008).
    Geotiff,
    /// ESRI ASCII grid: text.
    AsciiGrid,
}

/// Which point of a cell the coordinates in the file refer to (GeoTIFF's RasterPixelIsArea and
/// RasterPixelIsPoint).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PixelIs {
    /// A corner: the middle of the cell lies half a cell further.
    Area,
    /// The middle of the cell.
    Point,
}

/// Size and encoding of a raster.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RasterHeader {
    /// Format, recognised by the first bytes of the file.
    pub format: RasterFormat,
    /// Columns, 1 to `i32::MAX`.
    pub width: u32,
    /// Rows, 1 to `i32::MAX`.
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

/// Position of the middle of the north-western cell, and the sides of a cell, in the file's unit.
pub(crate) struct Placement {
    pub x_size: f64,
    pub y_size: f64,
    pub west: f64,
    pub north: f64,
    pub pixel_is: PixelIs,
}
