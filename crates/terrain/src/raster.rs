//! Opens raster files, elevation models and masks, of either format.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use contract::limits::LENGTH_MAX_M;

use crate::ascii_grid::AsciiGrid;
use crate::geotiff::GeoTiff;
use crate::raster_header::{ELEVATION_CELLS_MAX, Placement, RasterHeader};
use crate::{Elevation, Georeference, TerrainError, Window};

/// Cells smaller than this without a stated unit are assumed to be in degrees if the coordinates allow it.
const DEGREES_CELL_MAX: f64 = 0.02;

/// Most bytes read of a `.prj` file.
const PROJECTION_BYTES_MAX: u64 = 1 << 16;

/// An open raster file: the header is read, the cells are not.
pub struct RasterFile<R> {
    source: Source<R>,
    projection: Option<String>,
}

enum Source<R> {
    GeoTiff(GeoTiff<R>),
    AsciiGrid(AsciiGrid<R>),
}

impl RasterFile<BufReader<File>> {
    /// Opens the file at `path`, with the `.prj` file beside it if it has one.
    ///
    /// # Errors
    /// [`TerrainError::File`] with what is wrong.
    pub fn open(path: &Path) -> Result<Self, TerrainError> {
        let raster =
            regular(path).and_then(|file| Self::new(BufReader::new(file))).map_err(|error| error.of(path))?;
        let projection = regular(&path.with_extension("prj")).ok().and_then(|file| {
            let mut text = String::new();
            file.take(PROJECTION_BYTES_MAX).read_to_string(&mut text).ok().map(|_| text)
        });
        Ok(Self { projection, ..raster })
    }
}

impl<R: BufRead + Seek> RasterFile<R> {
    /// Reads the header from `reader`; the first bytes decide the format.
    ///
    /// # Errors
    /// If it is neither format, or its header is cut short, malformed or of an unsupported kind.
    pub fn new(mut reader: R) -> Result<Self, TerrainError> {
        let mut start = [0; 16];
        let mut length = 0;
        while length < start.len() {
            match reader.read(&mut start[length..])? {
                0 => break,
                more => length += more,
            }
        }
        reader.seek(SeekFrom::Start(0))?;
        let start = &start[..length];
        let source = if GeoTiff::<R>::begins(start) {
            Source::GeoTiff(GeoTiff::open(reader)?)
        } else if AsciiGrid::<R>::begins(start) {
            Source::AsciiGrid(AsciiGrid::open(reader)?)
        } else if start.is_empty() {
            return Err(TerrainError::Truncated { need: "a GeoTIFF or an ESRI ASCII grid".into() });
        } else {
            return Err(TerrainError::Format { got: start.escape_ascii().to_string() });
        };
        Ok(Self { source, projection: None })
    }

    /// Size, sample type, nodata value and scaling.
    #[must_use]
    pub fn header(&self) -> &RasterHeader {
        match &self.source {
            Source::GeoTiff(file) => &file.header,
            Source::AsciiGrid(file) => &file.header,
        }
    }

    /// Position, cell size and coordinate system.
    ///
    /// # Errors
    /// If the file has no position and scale, or they are in degrees, rotated, not square, not metres.
    pub fn georeference(&self) -> Result<Georeference, TerrainError> {
        let RasterHeader { width, height, .. } = *self.header();
        let (placement, system) = match &self.source {
            Source::GeoTiff(file) => (file.placement()?, file.keys.coordinate_system()),
            Source::AsciiGrid(file) => (file.placement(), Ok(None)),
        };
        let Placement { x_size, y_size, west, north, pixel_is } = placement;
        let half_span = |cells: u32, size: f64| (f64::from(cells) - 1.0) * size / 2.0;
        let middle = [west + half_span(width, x_size), north - half_span(height, y_size)];
        let system = match (system, &self.projection) {
            (Ok(None), Some(text)) => described_by_projection(text).map(Some),
            (system, _) => system,
        };
        let system = system.map_err(|error| error.around(middle))?;
        for (what, got) in [("cell size", x_size), ("cell size", y_size)] {
            if !(got.is_finite() && got > 0.0 && got <= LENGTH_MAX_M) {
                return Err(TerrainError::Value { what, need: "a length above 0 m, at most 1e6 m", got });
            }
        }
        for (what, got) in [("easting", west), ("northing", north)] {
            if !got.is_finite() {
                return Err(TerrainError::Value { what, need: "a finite number", got });
            }
        }
        let degrees = x_size < DEGREES_CELL_MAX
            && west.abs() <= 360.0
            && north.abs() <= 90.0 + y_size
            && f64::from(width) * x_size <= 360.0
            && f64::from(height) * y_size <= 180.0 + y_size;
        if system.is_none() && degrees {
            let got = format!("cells of {x_size} around ({west}, {north}) and no coordinate system named");
            return Err(TerrainError::Degrees { got, radius_m: None, centre_deg: Some(middle) });
        }
        if (x_size - y_size).abs() > 1e-6 * x_size {
            return Err(TerrainError::NotSquare { x_m: x_size, y_m: y_size });
        }
        Ok(Georeference {
            cell_size_m: x_size,
            west_m: west,
            south_m: north - f64::from(height - 1) * y_size,
            pixel_is,
            coordinate_system: system.unwrap_or_else(|| "none named, taken for metres".into()),
        })
    }

    /// The heights within `window`.
    ///
    /// # Errors
    /// If the window is not within the file or too large, the georeference unusable, the data cut short
    /// or malformed, or no cell has a height.
    pub fn elevation(mut self, window: Window) -> Result<Elevation, TerrainError> {
        let georeference = self.georeference()?;
        let heights_m = self.values(window)?;
        if heights_m.iter().all(|height| height.is_nan()) {
            return Err(TerrainError::NoHeights { cells: window.cells() });
        }
        Ok(Elevation {
            width: window.width,
            height: window.height,
            cell_size_m: georeference.cell_size_m,
            heights_m,
        })
    }

    /// The values within `window`, row-major, southernmost row first. NaN stands for nodata, for values that
    /// are not finite, and for those larger than [`LENGTH_MAX_M`].
    ///
    /// # Errors
    /// If the window is not within the file or too large, or the data cut short or malformed.
    pub fn values(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let RasterHeader { width, height, scale, offset, .. } = *self.header();
        if !window.is_within(width, height) {
            return Err(TerrainError::Window { window, width, height });
        }
        if window.cells() > ELEVATION_CELLS_MAX {
            return Err(TerrainError::CellsMax { cells_max: ELEVATION_CELLS_MAX, cells: window.cells() });
        }
        let mut values = match &mut self.source {
            Source::GeoTiff(file) => file.values(window)?,
            Source::AsciiGrid(file) => file.values(window)?,
        };
        for value in &mut values {
            let scaled = *value * scale + offset;
            *value = if scaled.abs() <= LENGTH_MAX_M { scaled } else { f64::NAN };
        }
        Ok(values)
    }
}

/// Opens a regular file only: opening a pipe might block for ever, and a device might never end.
fn regular(path: &Path) -> Result<File, TerrainError> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(TerrainError::Unsupported {
            what: "file",
            need: "a regular one",
            got: "a pipe, a device or a folder".into(),
            remedy: "copy it to a file first",
        });
    }
    Ok(File::open(path)?)
}

/// Name of the coordinate system in the well-known text of a `.prj` file; only the outermost keyword and
/// name are read.
fn described_by_projection(text: &str) -> Result<String, TerrainError> {
    let keyword = text.split(['[', '(']).next().unwrap_or_default().trim().to_ascii_uppercase();
    let name = text.split('"').nth(1).unwrap_or("unnamed").chars().take(80).collect::<String>();
    match keyword.as_str() {
        "GEOGCS" | "GEOGCRS" | "GEODCRS" | "GEOGRAPHICCRS" => Err(TerrainError::Degrees {
            got: format!("{name}, says its .prj file"),
            radius_m: radius_in_projection(text),
            centre_deg: None,
        }),
        _ => Ok(name),
    }
}

/// Equatorial radius of the body in the well-known text of a `.prj` file: the second field of SPHEROID or ELLIPSOID.
fn radius_in_projection(text: &str) -> Option<f64> {
    let upper = text.to_ascii_uppercase();
    let at = ["SPHEROID", "ELLIPSOID"].into_iter().find_map(|keyword| upper.find(keyword))?;
    let field = text.get(at..)?.split(',').nth(1)?;
    field.trim().parse().ok().filter(|radius_m| (1.0..1e9).contains(radius_m))
}
