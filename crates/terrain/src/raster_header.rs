//! What a raster file says of itself before its cells are read, whatever its format.

use serde::Serialize;

use crate::TerrainError;

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

/// Cells smaller than this without a stated unit are in degrees wherever a body has such longitudes and latitudes.
const DEGREES_CELL_MAX: f64 = 0.02;

/// Rotation, in cells a cell, that is taken for rounding.
const ROTATION_MAX: f64 = 1e-9;

impl Placement {
    /// From an affine transform: easting of the corner, its change a column and a row, and the same of the northing. `middle`
    /// is where the middle of a cell lies, in cells from the point that its coordinates refer to.
    pub fn of_transform(transform: [f64; 6], middle: f64, pixel_is: PixelIs) -> Result<Self, TerrainError> {
        let [d, a, b, h, e, f] = transform;
        let is_straight = b.abs() <= ROTATION_MAX * a && e.abs() <= ROTATION_MAX * -f;
        if !(is_straight && a > 0.0 && f < 0.0) {
            return Err(TerrainError::NotNorthUp { got: format!("x = {a} i + {b} j, y = {e} i + {f} j") });
        }
        Ok(Self { x_size: a, y_size: -f, west: d + a * middle, north: h + f * middle, pixel_is })
    }

    /// Easting and northing of the middle of a raster of so many cells.
    pub fn middle(&self, width: u32, height: u32) -> [f64; 2] {
        let half_span = |cells: u32, size: f64| (f64::from(cells) - 1.0) * size / 2.0;
        [self.west + half_span(width, self.x_size), self.north - half_span(height, self.y_size)]
    }

    /// Where a raster of so many cells lies, by its numbers alone. Longitudes and latitudes lie within -180 to 180 or 0 to 360, and
    /// -90 to 90, all but a cell for those that count to middles; beyond, around a meridian, where cells are whole parts of a
    /// degree. A raster whose corner is (0, 0) lies so too; it is local to a site, unless its cells are whole parts of a degree,
    /// or it covers quarters of a body.
    pub fn extent(&self, width: u32, height: u32) -> Extent {
        let Self { x_size, y_size, west, north, .. } = *self;
        if !(x_size > 0.0 && y_size > 0.0) {
            return Extent::Lengths;
        }
        let [width, height] = [f64::from(width) * x_size, f64::from(height) * y_size];
        let (west, north) = (west - x_size / 2.0, north + y_size / 2.0);
        let (east, south) = (west + width, north - height);
        let is_latitude = south >= -90.0 - y_size && north <= 90.0 + y_size;
        let is_small = x_size < DEGREES_CELL_MAX;
        let is_whole = |number: f64| (number - number.round()).abs() <= 1e-6 * number;
        let is_within = |from: f64, to: f64| west >= from - x_size && east <= to + x_size;
        let is_longitude = is_within(-180.0, 180.0)
            || is_within(0.0, 360.0)
            || width <= 360.0 + x_size
                && (is_small && is_within(-360.0, 720.0)
                    || is_whole(1.0 / x_size) && west < 360.0 && is_within(-360.0, 540.0));
        if !(is_latitude && is_longitude) {
            return Extent::Lengths;
        }
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * x_size;
        let at_origin = [0.0, x_size / 2.0].iter().any(|offset| {
            near(west + offset, 0.0) && (near(south + offset, 0.0) || near(north - offset, 0.0))
        });
        let is_part_of_degree = is_small || x_size < 1.0 - 1e-6 && is_whole(1.0 / x_size);
        let is_quarter = is_whole(width / 90.0) && is_whole(height / 90.0) || width >= 360.0 - x_size;
        if at_origin && !is_part_of_degree && !is_quarter { Extent::LocalOrDegrees } else { Extent::Degrees }
    }
}

/// What the numbers of a raster's place are, if nothing else says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// Lengths in a plane.
    Lengths,
    /// Longitudes and latitudes.
    Degrees,
    /// Either; lengths from the corner of a site are taken for granted.
    LocalOrDegrees,
}
