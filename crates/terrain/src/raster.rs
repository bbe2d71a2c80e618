//! Opens raster files, elevation models and layers, of either format.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use contract::limits::LENGTH_MAX_M;

use crate::ascii_grid::AsciiGrid;
use crate::crs::{CoordinateSystem, Heights, Kind};
use crate::fill::{self, Values};
use crate::geo_keys::agreed;
use crate::geotiff::{self, GeoTiff};
use crate::pam::Auxiliary;
use crate::raster_header::{ELEVATION_CELLS_MAX, PixelIs, Placement, RasterHeader};
use crate::tiff_image::Image;
use crate::unit::LengthUnit;
use crate::{Elevation, Fill, Georeference, Remark, TerrainError, Window, sidecar};

/// What programs write for the unit of a band that has none.
const NO_UNIT: [&str; 5] = ["unspecified", "unknown", "undefined", "none", "n/a"];

/// Sides of a cell that differ by less than this, relative to each other, are equal but for rounding.
const SQUARE_WITHIN: f64 = 1e-4;

/// Larger values than this are no distances from the centre of a body, metres.
const RADIUS_MAX_M: f64 = 1e9;

/// Share of the known cells from which on values beyond all heights are such distances, and not nodata.
const RADII_SHARE_MIN: f64 = 0.05;

/// An open raster file: the header is read, the cells are not.
pub struct RasterFile<R> {
    source: Source<R>,
    header: RasterHeader,
    /// What the file itself declares, where a file beside it declares another value.
    own_nodata: Option<f64>,
    auxiliary: Auxiliary,
    /// The `.prj` file beside it, and its text.
    projection: Option<(PathBuf, String)>,
    /// The `.msk` file beside it.
    mask: Option<(PathBuf, Image, BufReader<File>)>,
    /// Values that are settled to be nodata; `None` for the test of suspicion.
    settled: Option<Vec<f64>>,
}

enum Source<R> {
    GeoTiff(Box<GeoTiff<R>>),
    AsciiGrid(AsciiGrid<R>),
}

/// The heights of a model, where it lies, and what reading it had to decide.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// The heights.
    pub elevation: Elevation,
    /// Position and cells.
    pub georeference: Georeference,
    /// What was decided; empty for a plain model in metres.
    pub remarks: Vec<Remark>,
}

/// Where a raster lies, in metres, and the system that says so.
struct Located {
    georeference: Georeference,
    system: Option<CoordinateSystem>,
    remarks: Vec<Remark>,
}

impl RasterFile<BufReader<File>> {
    /// Opens the file at `path`, with the `.prj`, `.aux.xml` and `.msk` files beside it if it has them.
    ///
    /// # Errors
    /// [`TerrainError::File`] with what is wrong.
    pub fn open(path: &Path) -> Result<Self, TerrainError> {
        let mut raster =
            regular(path).and_then(|file| Self::new(BufReader::new(file))).map_err(|error| error.of(path))?;
        if let Some(file) = sidecar::with_extension(path, "prj") {
            let text = sidecar::text(&file).map_err(|error| error.of(&file))?;
            raster.projection = Some((file, text));
        }
        raster.add(Auxiliary::beside(path)?);
        if let Some(file) = sidecar::appended(path, ".msk") {
            let opened = regular(&file).and_then(|mask| GeoTiff::open_mask(BufReader::new(mask)));
            let (mask, reader) = opened.map_err(|error| error.of(&file))?;
            let (need_width, need_height) = (raster.header.width, raster.header.height);
            if (mask.width, mask.height) != (need_width, need_height) {
                let (got_width, got_height) = (mask.width, mask.height);
                let shape = TerrainError::LayerShape { need_width, need_height, got_width, got_height };
                return Err(shape.of(&file));
            }
            raster.mask = Some((file, mask, reader));
        }
        Ok(raster)
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
            Source::GeoTiff(Box::new(GeoTiff::open(reader)?))
        } else if AsciiGrid::<R>::begins(start) {
            Source::AsciiGrid(AsciiGrid::open(reader)?)
        } else if AsciiGrid::<R>::begins_in_utf16(start) {
            return Err(TerrainError::Unsupported {
                what: "encoding of the ASCII grid",
                need: "ASCII or UTF-8",
                got: "UTF-16".into(),
                remedy: "convert it with iconv -f UTF-16 -t ASCII IN > OUT",
            });
        } else if start.is_empty() {
            return Err(TerrainError::Truncated { need: "a GeoTIFF or an ESRI ASCII grid".into() });
        } else {
            return Err(TerrainError::Format { got: start.escape_ascii().to_string() });
        };
        let header = match &source {
            Source::GeoTiff(file) => file.header.clone(),
            Source::AsciiGrid(file) => file.header.clone(),
        };
        Ok(Self {
            source,
            header,
            own_nodata: None,
            auxiliary: Auxiliary::default(),
            projection: None,
            mask: None,
            settled: None,
        })
    }

    /// Puts what stands beside the file above what it says itself.
    fn add(&mut self, auxiliary: Auxiliary) {
        self.own_nodata = self.header.nodata;
        self.header.nodata = auxiliary.nodata.or(self.header.nodata);
        self.header.scale = auxiliary.scale.unwrap_or(self.header.scale);
        self.header.offset = auxiliary.offset.unwrap_or(self.header.offset);
        self.auxiliary = auxiliary;
    }

    /// Settles which stored values are nodata: `values`, beside what the file declares, and no others. Otherwise values that
    /// look like it are taken for it, and [`Survey::remarks`] says so.
    #[must_use]
    pub fn with_nodata(self, values: Option<Vec<f64>>) -> Self {
        Self { settled: values, ..self }
    }

    /// Size, sample type, nodata value and scaling.
    #[must_use]
    pub fn header(&self) -> &RasterHeader {
        &self.header
    }

    /// Position, cell size and coordinate system, in metres.
    ///
    /// # Errors
    /// If the file has no position and scale, or they are in degrees, rotated, not square, in no unit of length that is known.
    pub fn georeference(&self) -> Result<Georeference, TerrainError> {
        Ok(self.located()?.georeference)
    }

    fn placement(&self) -> Result<Placement, TerrainError> {
        match (self.auxiliary.transform, &self.source) {
            (Some(transform), _) => Placement::of_transform(transform, 0.5, PixelIs::Area),
            (None, Source::GeoTiff(file)) => file.placement(),
            (None, Source::AsciiGrid(file)) => Ok(file.placement()),
        }
    }

    /// The coordinate system: that of the auxiliary file, of the file itself, or of its `.prj` file.
    fn system(&self) -> Result<Option<CoordinateSystem>, TerrainError> {
        if let Some(text) = &self.auxiliary.system {
            return described(text, "its .aux.xml file");
        }
        let own = match &self.source {
            Source::GeoTiff(file) => file.keys.coordinate_system()?,
            Source::AsciiGrid(_) => None,
        };
        match (own, &self.projection) {
            (None, Some((file, text))) => described(text, "its .prj file").map_err(|error| error.of(file)),
            (own, _) => Ok(own),
        }
    }

    fn located(&self) -> Result<Located, TerrainError> {
        let RasterHeader { width, height, .. } = self.header;
        let placement = self.placement()?;
        let looks_like_degrees = placement.looks_like_degrees(width, height);
        let system = match self.system() {
            // A text that is not understood says nothing against what the numbers look like.
            Err(_) if looks_like_degrees => None,
            system => system?,
        };
        let kind = system.as_ref().and_then(|system| system.kind);
        let middle = placement.middle(width, height);
        let degrees = |got: String, radius_m| {
            Err(TerrainError::Degrees { got, radius_m, centre_deg: None }.around(middle))
        };
        let Placement { x_size, y_size, west, north, pixel_is } = placement;
        match (kind, &system) {
            (Some(Kind::Degrees { radius_m }), Some(system)) => {
                return degrees(system.name.clone(), radius_m);
            }
            (Some(Kind::Geocentric), _) => {
                return Err(TerrainError::Unsupported {
                    what: "coordinate system",
                    need: "a projected one in metres",
                    got: "a geocentric one".into(),
                    remedy: "reproject it with gdalwarp -t_srs",
                });
            }
            (None, _) if looks_like_degrees => {
                let got = format!(
                    "cells of {x_size} around ({west}, {north}) and no coordinate system named; for metres, put \
                     LOCAL_CS[\"site\",UNIT[\"metre\",1]] into a .prj file beside it"
                );
                return degrees(got, None);
            }
            _ => {}
        }
        let mut remarks = Vec::new();
        let unit = system.as_ref().and_then(|system| system.unit.clone());
        if let (Some(Kind::Plane), None, Some(system)) = (kind, &unit, &system) {
            remarks.push(Remark::NoUnit(system.name.clone()));
        }
        let unit = unit.unwrap_or_else(LengthUnit::metre);
        if !unit.is_metre() {
            remarks.push(Remark::CoordinatesConverted(unit.to_string()));
        }
        let [x_size, y_size, west, north] = [x_size, y_size, west, north].map(|length| length * unit.metres);
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
        if (x_size - y_size).abs() > SQUARE_WITHIN * x_size {
            return Err(TerrainError::NotSquare { x_m: x_size, y_m: y_size });
        }
        let name = system.as_ref().filter(|system| system.kind.is_some()).map(|system| system.name.clone());
        let georeference = Georeference {
            cell_size_m: x_size,
            west_m: west,
            south_m: north - f64::from(height - 1) * y_size,
            pixel_is,
            coordinate_system: name.unwrap_or_else(|| "none named, taken for metres".into()),
        };
        Ok(Located { georeference, system, remarks })
    }

    /// The unit of heights, which the band, the coordinate system, or both state.
    fn height_unit(&self, system: Option<&CoordinateSystem>) -> Result<LengthUnit, TerrainError> {
        let own = match &self.source {
            Source::GeoTiff(file) => file.unit.as_deref(),
            Source::AsciiGrid(_) => None,
        };
        let what = "unit of heights";
        let stated = self.auxiliary.unit.as_deref().or(own);
        let of_band = match stated.filter(|name| !NO_UNIT.contains(&name.to_ascii_lowercase().as_str())) {
            None => None,
            Some(name) => Some(LengthUnit::of_name(name).ok_or_else(|| TerrainError::Unsupported {
                what,
                need: "a unit of length",
                got: format!("{name:?}"),
                remedy: "name the right one with gdal_edit.py -units metre FILE",
            })?),
        };
        let heights = system.map_or_else(Heights::default, |system| system.heights.clone());
        if heights.downwards {
            return Err(TerrainError::Unsupported {
                what: "heights",
                need: "heights, positive upwards",
                got: "depths, positive downwards".into(),
                remedy: "turn them over: gdal_calc.py -A IN.tif --calc=-A --outfile OUT.tif",
            });
        }
        if let Some(unit) = agreed(what, [of_band, heights.unit])? {
            return Ok(unit);
        }
        let plane = system.and_then(|system| system.unit.clone()).unwrap_or_else(LengthUnit::metre);
        if !plane.is_same_as(&LengthUnit::metre()) {
            return Err(TerrainError::Unsupported {
                what,
                need: "the unit of heights beside coordinates that are not in metres",
                got: format!("coordinates in the {plane} and nothing said of heights"),
                remedy: "state it with gdal_edit.py -units metre FILE, or -units ft, and so on",
            });
        }
        Ok(LengthUnit::metre())
    }

    /// The heights within `window`, in metres.
    ///
    /// # Errors
    /// If the window is not within the file or too large, the georeference unusable, the data cut short
    /// or malformed, heights in an unknown unit or no heights at all, or no cell has a height.
    pub fn elevation(self, window: Window) -> Result<Elevation, TerrainError> {
        Ok(self.survey(window)?.elevation)
    }

    /// The heights within `window`, in metres, with what reading them had to decide.
    ///
    /// # Errors
    /// As [`RasterFile::elevation`].
    pub fn survey(mut self, window: Window) -> Result<Survey, TerrainError> {
        let Located { georeference, system, mut remarks } = self.located()?;
        let unit = self.height_unit(system.as_ref())?;
        if !unit.is_metre() {
            remarks.push(Remark::HeightsConverted(unit.to_string()));
        }
        if let Source::AsciiGrid(file) = &self.source
            && file.has_mark
        {
            remarks.push(Remark::ByteOrderMark);
        }
        let mut values = self.stored(window)?;
        let RasterHeader { scale, offset, .. } = self.header;
        let height_m = |stored: f64| (stored * scale + offset) * unit.metres;
        let beyond =
            values.iter().map(|stored| height_m(*stored)).filter(|height| height.abs() > LENGTH_MAX_M);
        refuse_radii(beyond.filter(|height| height.abs() < RADIUS_MAX_M), &values)?;
        for value in &mut values {
            let is_height = height_m(*value).abs() <= LENGTH_MAX_M;
            if !is_height {
                *value = f64::NAN;
            }
        }
        if self.settled.is_none() {
            let kind = if self.header.sample == "uint8" { Values::ByteHeights } else { Values::Heights };
            remarks.extend(fill::remove(&mut values, kind).into_iter().map(Remark::SuspectedNodata));
        }
        if values.iter().all(|value| value.is_nan()) {
            return Err(TerrainError::NoHeights { cells: window.cells() });
        }
        let elevation = Elevation {
            width: window.width,
            height: window.height,
            cell_size_m: georeference.cell_size_m,
            heights_m: values.into_iter().map(height_m).collect(),
        };
        Ok(Survey { elevation, georeference, remarks })
    }

    /// The values within `window`, row-major, southernmost row first. NaN stands for nodata, for cells that a mask leaves out,
    /// for values that are not finite, and for those larger than [`LENGTH_MAX_M`].
    ///
    /// # Errors
    /// If the window is not within the file or too large, or the data cut short or malformed.
    pub fn values(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let stored = self.stored(window)?;
        Ok(self.scaled(stored))
    }

    /// [`RasterFile::values`] of a layer of codes or shares, without those that look like nodata.
    pub(crate) fn layer(&mut self, window: Window) -> Result<(Vec<f64>, Vec<Fill>), TerrainError> {
        let mut stored = self.stored(window)?;
        let fills = fill::remove(&mut stored, Values::Layer);
        Ok((self.scaled(stored), fills))
    }

    fn scaled(&self, mut values: Vec<f64>) -> Vec<f64> {
        let RasterHeader { scale, offset, .. } = self.header;
        for value in &mut values {
            let scaled = *value * scale + offset;
            *value = if scaled.abs() <= LENGTH_MAX_M { scaled } else { f64::NAN };
        }
        values
    }

    /// The values as they are stored; NaN for nodata and for cells that a mask leaves out.
    fn stored(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let RasterHeader { width, height, .. } = self.header;
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
        if let Some((path, mask, reader)) = &mut self.mask {
            let counts = mask.values(reader, window).map_err(|error| error.of(path))?;
            geotiff::apply(&mut values, &counts);
        }
        let declared = [self.header.nodata, self.own_nodata].into_iter().flatten();
        let nodata: Vec<f64> = declared.chain(self.settled.iter().flatten().copied()).collect();
        // Fractions lose digits on the way through float32, and in the text of a header.
        let has_fractions = ["text", "float32", "float64"].contains(&self.header.sample);
        let is_nodata = |value: f64| {
            nodata.iter().any(|nodata| *nodata == value || has_fractions && *nodata as f32 == value as f32)
        };
        for value in &mut values {
            if is_nodata(*value) {
                *value = f64::NAN;
            }
        }
        Ok(values)
    }

    /// Where a further raster of the cells at `place` lies, as far as it says so: `None` if it names no position, or lies there.
    pub(crate) fn lies_elsewhere(&self, place: &Georeference) -> Result<Option<Georeference>, TerrainError> {
        let far_m = 1e-3 * place.cell_size_m;
        let side = f64::from(self.header.width.max(self.header.height));
        let is_near = |cell_m: f64, west_m: f64, south_m: f64| {
            let differs =
                [(place.cell_size_m - cell_m) * side, place.west_m - west_m, place.south_m - south_m];
            differs.iter().all(|by_m| by_m.abs() <= far_m)
        };
        let placement = match self.placement() {
            Err(TerrainError::NoGeoreference) => return Ok(None),
            placement => placement?,
        };
        let south = placement.north - f64::from(self.header.height - 1) * placement.y_size;
        // The same numbers are the same place where the raster does not say in which system they are.
        if is_near(placement.x_size, placement.west, south) && matches!(self.system(), Ok(None)) {
            return Ok(None);
        }
        let got = self.georeference()?;
        Ok(if is_near(got.cell_size_m, got.west_m, got.south_m) { None } else { Some(got) })
    }
}

/// Refuses heights of which many are as large as the distance from the centre of a body.
fn refuse_radii(beyond: impl Iterator<Item = f64>, values: &[f64]) -> Result<(), TerrainError> {
    let (mut cells, mut min_m, mut max_m) = (0_u64, f64::INFINITY, f64::NEG_INFINITY);
    for height in beyond {
        (cells, min_m, max_m) = (cells + 1, min_m.min(height), max_m.max(height));
    }
    let known = values.iter().filter(|value| !value.is_nan()).count() as f64;
    if cells as f64 <= RADII_SHARE_MIN * known || min_m < 0.0 || min_m == max_m {
        return Ok(());
    }
    Err(TerrainError::Radii { min_m, max_m })
}

/// The system that `text` describes; errors and degrees name `whose` text it is.
fn described(text: &str, whose: &str) -> Result<Option<CoordinateSystem>, TerrainError> {
    let system = CoordinateSystem::of_text(text).map_err(|error| {
        let got = error.split_once("got ").map_or(String::new(), |(_, got)| got.to_owned());
        let need = error.split_once(", got ").map_or(error.clone(), |(need, _)| need.to_owned());
        TerrainError::CoordinateSystem { need, got }
    })?;
    Ok(system.map(|mut system| {
        if matches!(system.kind, Some(Kind::Degrees { .. })) {
            system.name = format!("{}, says {whose}", system.name);
        }
        system
    }))
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
