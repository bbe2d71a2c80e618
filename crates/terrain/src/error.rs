//! Errors of reading and preparing terrain.

use std::path::PathBuf;

use contract::grid::GridError;

use crate::Window;

/// Why terrain cannot be read or prepared: each message says what was needed, what was got and what to do.
#[derive(Debug, thiserror::Error)]
pub enum TerrainError {
    /// Any of the other errors, with the file it occurred in.
    #[error("{}: {source}", path.display())]
    File {
        /// File that was read.
        path: PathBuf,
        /// The error itself.
        source: Box<TerrainError>,
    },
    /// The file cannot be read at all.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The file is in neither of the formats that are read.
    #[error(
        "need a GeoTIFF or an ESRI ASCII grid, got a file that begins with {got}; convert it with gdal_translate"
    )]
    Format {
        /// Its first bytes, escaped.
        got: String,
    },
    /// The file ends too early.
    #[error("need {need}, got the end of the file; it was cut short, so copy or download it again")]
    Truncated {
        /// What the header announced.
        need: String,
    },
    /// A field of the file has an impossible value.
    #[error("{what}: need {need}, got {got}; the file is damaged or not what it claims, so export it again")]
    Malformed {
        /// Name of the field.
        what: &'static str,
        /// Allowed values.
        need: String,
        /// Value in the file.
        got: String,
    },
    /// The file is valid, but of a kind that is not read.
    #[error("{what}: need {need}, got {got}; {remedy}")]
    Unsupported {
        /// Property of the file, such as its compression.
        what: &'static str,
        /// Values that are read.
        need: &'static str,
        /// Value of the file.
        got: String,
        /// Command or advice that makes the file readable.
        remedy: &'static str,
    },
    /// The cells are measured in degrees.
    #[error(
        "need cells in metres, got geographic coordinates in degrees ({got}); reproject it to a metric system, \
         for example: gdalwarp -t_srs '+proj=eqc +R=3396190 +units=m' -r bilinear IN.tif OUT.tif"
    )]
    Degrees {
        /// What in the file says so.
        got: String,
    },
    /// The rows do not run from west to east, northernmost first.
    #[error(
        "need a north-up raster, got a rotated or flipped one ({got}); straighten it with gdalwarp IN.tif OUT.tif"
    )]
    NotNorthUp {
        /// Terms of the transform that rotate or flip.
        got: String,
    },
    /// The cells are not square.
    #[error(
        "need square cells, got {x_m} m x {y_m} m; resample it, for example: gdalwarp -tr {x_m} {x_m} IN OUT"
    )]
    NotSquare {
        /// Side from west to east, metres.
        x_m: f64,
        /// Side from south to north, metres.
        y_m: f64,
    },
    /// The file gives no position and no cell size.
    #[error(
        "need the size of a cell (ModelPixelScale with ModelTiepoint, or ModelTransformation), got none; \
         state it with gdal_translate -a_ullr WEST NORTH EAST SOUTH IN OUT"
    )]
    NoGeoreference,
    /// More cells were asked for than are read at once.
    #[error("need at most {cells_max} cells, got {cells}; crop it (crop_cells or crop_m in a scenario)")]
    CellsMax {
        /// Most cells that are read at once.
        cells_max: u64,
        /// Cells of the requested window.
        cells: u64,
    },
    /// No cell of the window has a height.
    #[error("need heights, got nodata or NaN in all {cells} cells; choose another file or another crop")]
    NoHeights {
        /// Cells of the window.
        cells: u64,
    },
    /// The crop is empty or reaches beyond the file.
    #[error(
        "need a crop within the file's {width} x {height} cells, got {} x {} cells from ({}, {})",
        window.width, window.height, window.x, window.y
    )]
    Window {
        /// Crop as given.
        window: Window,
        /// Columns of the file.
        width: u32,
        /// Rows of the file.
        height: u32,
    },
    /// A crop in metres covers no cell, or reaches beyond the file.
    #[error("need a crop that covers cells between {have}, got {got}")]
    Crop {
        /// Extent of the file: eastings and northings, metres.
        have: String,
        /// Crop as given, metres.
        got: String,
    },
    /// A number is out of its range.
    #[error("{what}: need {need}, got {got}")]
    Value {
        /// What the number is.
        what: &'static str,
        /// Allowed range, with its unit.
        need: &'static str,
        /// Value in the file or scenario.
        got: f64,
    },
    /// The sand mask has another shape than the terrain.
    #[error(
        "a sand mask needs the shape of the terrain it lies on, {need_width} x {need_height} cells, got {got_width} x {got_height}"
    )]
    MaskShape {
        /// Columns of the terrain.
        need_width: u32,
        /// Rows of the terrain.
        need_height: u32,
        /// Columns of the mask.
        got_width: u32,
        /// Rows of the mask.
        got_height: u32,
    },
    /// A hop is not a whole number of cells.
    #[error(
        "need a hop of a whole number of cells, got {hop_distance_m} m over cells of {cell_size_m} m; \
         set cell_size_m = {resample_m} of the terrain, which resamples an elevation file"
    )]
    HopOverCell {
        /// Length of one hop, metres.
        hop_distance_m: f64,
        /// Edge of a cell, metres.
        cell_size_m: f64,
        /// Nearest cell size that divides the hop, metres.
        resample_m: f64,
    },
    /// The lattice exceeds the bounds of a grid.
    #[error("{0}; crop the terrain or take larger cells (cell_size_m)")]
    Grid(#[from] GridError),
}

impl TerrainError {
    /// This error with the file it occurred in.
    #[must_use]
    pub fn of(self, path: &std::path::Path) -> Self {
        TerrainError::File { path: path.into(), source: Box::new(self) }
    }
}
