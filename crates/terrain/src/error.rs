//! Why there is no terrain.

use std::path::PathBuf;

use contract::grid::GridError;

use crate::Window;

/// What was needed, what was got, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum TerrainError {
    /// Something is wrong with a file.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<TerrainError>,
    },
    /// The file cannot be read at all.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// Neither format.
    #[error(
        "need a GeoTIFF or an ESRI ASCII grid, got a file that begins with {got}; convert it with gdal_translate"
    )]
    Format {
        /// Its first bytes, printable.
        got: String,
    },
    /// The file ends too early.
    #[error("need {need}, got the end of the file; it was cut short, so copy or download it again")]
    Truncated {
        /// What should have come.
        need: String,
    },
    /// A field makes no sense.
    #[error("{what}: need {need}, got {got}; the file is damaged or not what it claims, so export it again")]
    Malformed {
        /// The field.
        what: &'static str,
        /// What it should be.
        need: String,
        /// What it is.
        got: String,
    },
    /// A legitimate file of a kind that is not read.
    #[error("{what}: need {need}, got {got}; {remedy}")]
    Unsupported {
        /// The property.
        what: &'static str,
        /// What is read.
        need: &'static str,
        /// What the file has.
        got: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Cells measured in degrees.
    #[error(
        "need cells in metres, got geographic coordinates in degrees ({got}); reproject it to a metric system, \
         for example: gdalwarp -t_srs '+proj=eqc +R=3396190 +units=m' -r bilinear IN.tif OUT.tif"
    )]
    Degrees {
        /// How that was found out.
        got: String,
    },
    /// Rows that do not run from west to east, north first.
    #[error(
        "need a north-up raster, got a rotated or flipped one ({got}); straighten it with gdalwarp IN.tif OUT.tif"
    )]
    NotNorthUp {
        /// The transform's offending terms.
        got: String,
    },
    /// Cells that are not square.
    #[error(
        "need square cells, got {x_m} m x {y_m} m; resample it, for example: gdalwarp -tr {x_m} {x_m} IN OUT"
    )]
    NotSquare {
        /// West to east, metres.
        x_m: f64,
        /// South to north, metres.
        y_m: f64,
    },
    /// No position and scale.
    #[error(
        "need the size of a cell (ModelPixelScale with ModelTiepoint, or ModelTransformation), got none; \
         state it with gdal_translate -a_ullr WEST NORTH EAST SOUTH IN OUT"
    )]
    NoGeoreference,
    /// Too many cells to read.
    #[error("need at most {cells_max} cells, got {cells}; crop it (crop_cells or crop_m in a scenario)")]
    CellsMax {
        /// Most cells that are read at once.
        cells_max: u64,
        /// Cells asked for.
        cells: u64,
    },
    /// Nothing but nodata.
    #[error("need heights, got nodata or NaN in all {cells} cells; choose another file or another crop")]
    NoHeights {
        /// Cells read.
        cells: u64,
    },
    /// A crop beyond the edge.
    #[error(
        "need a crop within the file's {width} x {height} cells, got {} x {} cells from ({}, {})",
        window.width, window.height, window.x, window.y
    )]
    Window {
        /// The crop.
        window: Window,
        /// Columns there are.
        width: u32,
        /// Rows there are.
        height: u32,
    },
    /// A crop in metres that covers nothing.
    #[error("need a crop that covers cells between {have}, got {got}")]
    Crop {
        /// The file's extent.
        have: String,
        /// The crop.
        got: String,
    },
    /// A number out of its range.
    #[error("{what}: need {need}, got {got}")]
    Value {
        /// The number.
        what: &'static str,
        /// Its range.
        need: &'static str,
        /// Its value.
        got: f64,
    },
    /// A sand mask of another shape.
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
    /// Hops that do not end on cells.
    #[error(
        "need a hop of a whole number of cells, got {hop_distance_m} m over cells of {cell_size_m} m; \
         set cell_size_m = {resample_m} of the terrain, which resamples an elevation file"
    )]
    HopOverCell {
        /// Length of a hop.
        hop_distance_m: f64,
        /// Edge of a cell.
        cell_size_m: f64,
        /// The nearest cell size that would do.
        resample_m: f64,
    },
    /// A lattice out of bounds.
    #[error("{0}; crop the terrain or take larger cells (cell_size_m)")]
    Grid(#[from] GridError),
}

impl TerrainError {
    /// The error as one of `path`.
    #[must_use]
    pub fn of(self, path: &std::path::Path) -> Self {
        TerrainError::File { path: path.into(), source: Box::new(self) }
    }
}
