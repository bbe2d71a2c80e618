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
        "need a GeoTIFF or an ESRI ASCII grid, got a file that begins with {got}; convert it with \
         gdal_translate -of GTiff IN OUT.tif, as --convert does where GDAL is installed"
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
    #[error("need cells in metres, got geographic coordinates in degrees ({got}); {}", reprojection(*radius_m, *centre_deg))]
    Degrees {
        /// What in the file says so.
        got: String,
        /// Equatorial radius of the body, metres; `None` where the file does not give it.
        radius_m: Option<f64>,
        /// Longitude and latitude of the middle of the file, degrees; `None` where they are not known.
        centre_deg: Option<[f64; 2]>,
    },
    /// A text that describes the coordinate system is not understood.
    #[error(
        "coordinate system: need {need}, got {got}; correct the text, or remove it if the cells are in metres"
    )]
    CoordinateSystem {
        /// Dialects or words that are understood.
        need: String,
        /// What the text says.
        got: String,
    },
    /// The values are distances from the centre of a body.
    #[error(
        "need heights above a datum, got radii: distances from the centre of the body, {min_m} to {max_m} m; subtract the \
         radius that heights shall count from, for example: {remedy}"
    )]
    Radii {
        /// Least distance, metres.
        min_m: f64,
        /// Greatest distance, metres.
        max_m: f64,
        /// The command that subtracts it.
        remedy: String,
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
    #[error(
        "need at most {cells_max} cells, got {cells}; crop it (--crop of terrain check, crop_cells or crop_m in a scenario)"
    )]
    CellsMax {
        /// Most cells that are read at once.
        cells_max: u64,
        /// Cells of the requested window.
        cells: u64,
    },
    /// No cell of the window has a height.
    #[error("need heights, got nodata or NaN in all {cells} cells{why}; choose another file or another crop")]
    NoHeights {
        /// Cells of the window.
        cells: u64,
        /// Which values were taken for nodata, a semicolon before each; empty if the file declares them.
        why: String,
    },
    /// The ground is steeper than any that is simulated.
    #[error(
        "need slopes below {gradient_max} m a metre, got {gradient} m between heights from {min_m} to {max_m} m; if one of \
         these marks cells without data, settle it with --nodata VALUE"
    )]
    TooSteep {
        /// Steepest slope allowed, metres a metre.
        gradient_max: f64,
        /// Slope of the ground.
        gradient: f64,
        /// Lowest height, metres.
        min_m: f64,
        /// Highest height, metres.
        max_m: f64,
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
        "a further raster needs the shape of the terrain that it lies on, {need_width} x {need_height} cells, got {got_width} x {got_height}"
    )]
    LayerShape {
        /// Columns of the terrain.
        need_width: u32,
        /// Rows of the terrain.
        need_height: u32,
        /// Columns of the raster.
        got_width: u32,
        /// Rows of the raster.
        got_height: u32,
    },
    /// Another raster of the same ground lies elsewhere.
    #[error(
        "a further raster needs the cells of the elevation model, {need}, got {got}; cut it out of the same extent"
    )]
    LayerPosition {
        /// Cells of the elevation model.
        need: String,
        /// Cells of the raster.
        got: String,
    },
    /// A further raster has the numbers of the model in another coordinate system.
    #[error(
        "a further raster needs the coordinate system of the elevation model, {need}, got {got}; reproject it with gdalwarp \
         -t_srs, or correct what it says with gdal_edit.py -a_srs"
    )]
    LayerSystem {
        /// Coordinate system of the elevation model.
        need: String,
        /// Coordinate system of the raster.
        got: String,
    },
    /// A hop is not a whole number of cells.
    #[error(
        "need a hop of a whole number of cells, got {hop_distance_m} m over cells of {cell_size_m} m; \
         set cell_size_m = {resample_m} of the terrain, which resamples an elevation file, or \
         robot.hop_distance_m = {fitting_m}"
    )]
    HopOverCell {
        /// Length of one hop, metres.
        hop_distance_m: f64,
        /// Edge of a cell, metres.
        cell_size_m: f64,
        /// Nearest hop of whole cells, metres.
        fitting_m: f64,
        /// Nearest cell size that divides the hop, metres.
        resample_m: f64,
    },
    /// The lattice exceeds the bounds of a grid.
    #[error("{0}; crop the terrain or take larger cells (cell_size_m)")]
    Grid(#[from] GridError),
}

/// The command that projects a file in degrees onto a plane in metres. An azimuthal projection about the file's own
/// middle keeps its cells square at any latitude.
fn reprojection(radius_m: Option<f64>, centre_deg: Option<[f64; 2]>) -> String {
    let (body, note) = match radius_m {
        Some(radius_m) if EARTH_RADII_M.contains(&radius_m) => ("+ellps=WGS84".to_owned(), ""),
        Some(radius_m) => (format!("+R={radius_m}"), ""),
        None => (
            "+R=RADIUS".to_owned(),
            ", where RADIUS is that of the body in metres (6371000 of the Earth, 3396190 of Mars, 1737400 of the Moon)",
        ),
    };
    let [longitude, latitude] = match centre_deg {
        Some(centre_deg) => centre_deg.map(|degrees| ((1e4 * degrees).round() / 1e4 + 0.0).to_string()),
        None => ["LONGITUDE", "LATITUDE"].map(str::to_owned),
    };
    format!(
        "reproject it to metres, for example: gdalwarp -t_srs '+proj=laea +lat_0={latitude} +lon_0={longitude} \
         {body} +units=m' -r bilinear IN.tif OUT.tif{note}"
    )
}

/// Radii that can only be the Earth's, metres.
const EARTH_RADII_M: std::ops::RangeInclusive<f64> = 6.3e6..=6.4e6;

impl TerrainError {
    /// This error, if it is that of coordinates in degrees, with the middle of the file, in degrees.
    #[must_use]
    pub(crate) fn around(self, middle_deg: [f64; 2]) -> Self {
        match self {
            TerrainError::Degrees { got, radius_m, .. } => {
                let [longitude, latitude] = middle_deg;
                let is_place = longitude.abs() <= 360.0 && latitude.abs() <= 90.0;
                TerrainError::Degrees { got, radius_m, centre_deg: is_place.then_some(middle_deg) }
            }
            other => other,
        }
    }

    /// This error with the file it occurred in.
    #[must_use]
    pub fn of(self, path: &std::path::Path) -> Self {
        TerrainError::File { path: path.into(), source: Box::new(self) }
    }
}
