//! Opens raster files, elevation models and layers, of either format.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use contract::limits::LENGTH_MAX_M;

use crate::ascii_grid::AsciiGrid;
use crate::crs::{CoordinateSystem, Heights, Identity, Kind};
use crate::fill::{self, Kind as Values, Test};
use crate::geo_keys::agreed;
use crate::geotiff::{self, GeoTiff};
use crate::pam::Auxiliary;
use crate::radii::{self, Beyond, RADIUS_MAX_M, Scaling};
use crate::raster_header::{ELEVATION_CELLS_MAX, Extent, PixelIs, Placement, RasterHeader};
use crate::tiff_image::Image;
use crate::unit::LengthUnit;
use crate::{Elevation, Fill, Georeference, Remark, TerrainError, Window, interpolated, pds_label, sidecar};

/// What programs write for the unit of a band that has none.
const NO_UNIT: [&str; 5] = ["unspecified", "unknown", "undefined", "none", "n/a"];

/// Sides of a cell that differ by less than this, relative to each other, are equal but for rounding.
const SQUARE_WITHIN: f64 = 1e-4;

/// An open raster file: the header is read, the cells are not.
pub struct RasterFile<R> {
    source: Source<R>,
    header: RasterHeader,
    /// What the file itself declares, where a file beside it declares another value.
    own_nodata: Option<f64>,
    /// What its metadata declare besides.
    further_nodata: Vec<f64>,
    auxiliary: Auxiliary,
    /// The `.prj` files beside it, and their texts.
    projections: Vec<(PathBuf, String)>,
    /// The `.msk` files beside it.
    masks: Vec<(PathBuf, Image, BufReader<File>)>,
    /// Whether a world file beside it says where it lies.
    has_world_file: bool,
    /// The unit of heights in the label of the file that it was converted from.
    label_unit: Option<String>,
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
    /// Opens the file at `path`, with the `.prj`, `.aux.xml` and `.msk` files beside it if it has them. Where it was converted
    /// from another file, those of that count as well: a converter may not know them.
    ///
    /// # Errors
    /// [`TerrainError::File`] with what is wrong.
    pub fn open(path: &Path) -> Result<Self, TerrainError> {
        let mut raster =
            regular(path).and_then(|file| Self::new(BufReader::new(file))).map_err(|error| error.of(path))?;
        raster.add(Auxiliary::beside(path)?);
        raster.add_beside(path)?;
        raster.has_world_file =
            ["tfw", "tifw", "wld"].iter().any(|extension| sidecar::with_extension(path, extension).is_some());
        if let Some(source) = sidecar::converted_from(path) {
            raster.add_beside(&source)?;
            raster.label_unit = pds_label::unit(&source).map_err(|error| error.of(&source))?;
        }
        Ok(raster)
    }

    /// Adds the coordinate system and the mask beside the file at `path`.
    fn add_beside(&mut self, path: &Path) -> Result<(), TerrainError> {
        if let Some(file) = sidecar::with_extension(path, "prj") {
            let text = sidecar::text(&file).map_err(|error| error.of(&file))?;
            self.projections.push((file, text));
        }
        if let Some(file) = sidecar::appended(path, ".msk") {
            let opened = regular(&file).and_then(|mask| {
                let mut mask = BufReader::new(mask);
                let start = mask.fill_buf()?;
                if !GeoTiff::<BufReader<File>>::begins(start) {
                    return Err(TerrainError::Unsupported {
                        what: "mask beside the raster",
                        need: "a TIFF, as GDAL writes it",
                        got: format!(
                            "a file that begins with {}",
                            start[..start.len().min(16)].escape_ascii()
                        ),
                        remedy: "convert it with gdal_translate -of GTiff, or remove it",
                    });
                }
                GeoTiff::open_mask(mask)
            });
            let (mask, reader) = opened.map_err(|error| error.of(&file))?;
            let (need_width, need_height) = (self.header.width, self.header.height);
            if (mask.width, mask.height) != (need_width, need_height) {
                let (got_width, got_height) = (mask.width, mask.height);
                let shape = TerrainError::LayerShape { need_width, need_height, got_width, got_height };
                return Err(shape.of(&file));
            }
            self.masks.push((file, mask, reader));
        }
        Ok(())
    }
}

impl<R: BufRead + Seek> RasterFile<R> {
    /// Reads the header from `reader`; the first bytes decide the format.
    ///
    /// # Errors
    /// If it is neither format, or its header is cut short, malformed or of an unsupported kind.
    pub fn new(mut reader: R) -> Result<Self, TerrainError> {
        let mut start = [0; 512];
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
            return Err(TerrainError::Format {
                got: start[..start.len().min(16)].escape_ascii().to_string(),
            });
        };
        let header = match &source {
            Source::GeoTiff(file) => file.header.clone(),
            Source::AsciiGrid(file) => file.header.clone(),
        };
        let further_nodata = match &source {
            Source::GeoTiff(file) => file.further_nodata.clone(),
            Source::AsciiGrid(_) => Vec::new(),
        };
        Ok(Self {
            source,
            header,
            own_nodata: None,
            further_nodata,
            auxiliary: Auxiliary::default(),
            projections: Vec::new(),
            masks: Vec::new(),
            has_world_file: false,
            label_unit: None,
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

    /// The coordinate system: what the auxiliary file, the file itself and its `.prj` file say together. A later text that is
    /// not understood says nothing against an earlier one.
    fn system(&self) -> Result<Option<CoordinateSystem>, TerrainError> {
        let own = match &self.source {
            Source::GeoTiff(file) => file.keys.coordinate_system(),
            Source::AsciiGrid(_) => Ok(None),
        };
        let auxiliary =
            self.auxiliary.system.as_ref().map_or(Ok(None), |text| described(text, "its .aux.xml file"));
        let beside = self
            .projections
            .iter()
            .map(|(file, text)| described(text, "its .prj file").map_err(|error| error.of(file)));
        let mut stated: Option<CoordinateSystem> = None;
        for source in [auxiliary, own].into_iter().chain(beside) {
            let is_known = stated.as_ref().is_some_and(|system| system.kind.is_some());
            stated = match (stated, source) {
                (stated, Err(_)) if is_known => stated,
                (_, Err(error)) => return Err(error),
                (stated, Ok(None)) => stated,
                (None, Ok(next)) => next,
                (Some(stated), Ok(Some(next))) => Some(together(stated, next)?),
            };
        }
        Ok(stated)
    }

    fn located(&self) -> Result<Located, TerrainError> {
        let RasterHeader { width, height, .. } = self.header;
        let placement = match self.placement() {
            Err(TerrainError::NoGeoreference) if self.has_world_file => {
                return Err(TerrainError::Unsupported {
                    what: "size of a cell",
                    need: "ModelPixelScale with ModelTiepoint, or ModelTransformation",
                    got: "a world file beside the raster alone".into(),
                    remedy: "write it into the raster: gdal_translate IN.tif OUT.tif",
                });
            }
            placement => placement?,
        };
        let extent = placement.extent(width, height);
        let looks_like_degrees = extent == Extent::Degrees;
        let system = match self.system() {
            // A text that is not understood says nothing against what the numbers look like.
            Err(TerrainError::CoordinateSystem { .. }) if looks_like_degrees => None,
            Err(TerrainError::File { source, .. })
                if looks_like_degrees && matches!(*source, TerrainError::CoordinateSystem { .. }) =>
            {
                None
            }
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
        if kind.is_none() && extent == Extent::LocalOrDegrees {
            remarks.push(Remark::TakenForLocal);
        }
        let unit = system.as_ref().and_then(|system| system.unit.clone());
        if let (Some(Kind::Plane), None, Some(system)) = (kind, &unit, &system) {
            remarks.push(Remark::NoUnit(system.name.clone()));
        }
        let unit = unit.unwrap_or_else(LengthUnit::metre);
        if !unit.is_metre() {
            remarks.push(Remark::CoordinatesConverted(unit.to_string()));
        }
        let unit_m = unit.metres;
        let [x_size, y_size, west, north] = [x_size, y_size, west, north].map(|length| length * unit_m);
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
        let named = system.as_ref().filter(|system| system.kind.is_some());
        let identity = named.map_or_else(Identity::default, |system| system.identity.clone());
        let name = named.map(|system| system.name.clone());
        let georeference = Georeference {
            cell_size_m: x_size,
            west_m: west,
            south_m: north - f64::from(height - 1) * y_size,
            pixel_is,
            coordinate_system: name.unwrap_or_else(|| "none named, taken for metres".into()),
            identity,
            unit_m,
        };
        Ok(Located { georeference, system, remarks })
    }

    /// The unit of heights, which the band, the coordinate system, or both state; `None` for metres by default.
    fn height_unit(&self, system: Option<&CoordinateSystem>) -> Result<Option<LengthUnit>, TerrainError> {
        let own = match &self.source {
            Source::GeoTiff(file) => file.unit.as_deref(),
            Source::AsciiGrid(_) => None,
        };
        let what = "unit of heights";
        let of_band = |name: Option<&str>| match name {
            Some(name) if !NO_UNIT.contains(&name.to_ascii_lowercase().as_str()) => {
                let unknown = || TerrainError::Unsupported {
                    what,
                    need: "a unit of length",
                    got: format!("{name:?}"),
                    remedy: "name the right one with gdal_edit.py -units metre FILE",
                };
                LengthUnit::of_words(name).map(Some).ok_or_else(unknown)
            }
            _ => Ok(None),
        };
        let stated = of_band(self.auxiliary.unit.as_deref().or(own))?;
        let of_label = of_band(self.label_unit.as_deref())?;
        let heights = system.map_or_else(Heights::default, |system| system.heights.clone());
        if heights.downwards {
            return Err(TerrainError::Unsupported {
                what: "heights",
                need: "heights, positive upwards",
                got: "depths, positive downwards".into(),
                remedy: "turn them over: gdal_calc.py -A IN.tif --calc=-A --outfile OUT.tif",
            });
        }
        if let Some(unit) = agreed(what, [stated, of_label, heights.unit])? {
            return Ok(Some(unit));
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
        Ok(None)
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
        let stated = self.height_unit(system.as_ref())?;
        if let Some(name) = system.as_ref().and_then(|system| system.heights.maybe_feet.clone())
            && stated.is_none()
        {
            remarks.push(Remark::MaybeFeet(name));
        }
        let unit = stated.unwrap_or_else(LengthUnit::metre);
        if !unit.is_metre() {
            remarks.push(Remark::HeightsConverted(unit.to_string()));
        }
        if let Source::AsciiGrid(file) = &self.source
            && file.has_mark
        {
            remarks.push(Remark::ByteOrderMark);
        }
        let values = self.heights_in(window, &georeference, system.as_ref(), &unit, &mut remarks)?;
        let elevation = Elevation {
            width: window.width,
            height: window.height,
            cell_size_m: georeference.cell_size_m,
            heights_m: values,
        };
        Ok(Survey { elevation, georeference, remarks })
    }

    /// The heights within `window`, metres; NaN for what has none.
    fn heights_in(
        &mut self,
        window: Window,
        georeference: &Georeference,
        system: Option<&CoordinateSystem>,
        unit: &LengthUnit,
        remarks: &mut Vec<Remark>,
    ) -> Result<Vec<f64>, TerrainError> {
        let RasterHeader { scale, offset, .. } = self.header;
        let height_m = |stored: f64| (stored * scale + offset) * unit.metres;
        let mut values = self.cells(window)?;
        let mut sample = self.sample(window);
        let was_number: Vec<bool> = values.iter().map(|value| value.is_finite()).collect();
        let mut nodata = self.declared();
        let is_settled = match self.settled.take() {
            None => false,
            Some(settled) => {
                let (found, missing) = self.found(&settled, [&values, &sample]);
                remarks.extend(missing.iter().map(|value| Remark::NoCellHolds(*value)));
                nodata.extend(found);
                missing.is_empty()
            }
        };
        for part in [&mut values, &mut sample] {
            self.clear(part, &nodata);
        }
        // What no body has room for would stretch the range of everything else.
        let mut beyond = Beyond::default();
        let is_nowhere = |stored: &&mut f64| height_m(**stored).abs() >= RADIUS_MAX_M;
        values.iter_mut().filter(is_nowhere).for_each(|stored| {
            beyond.count(height_m(*stored));
            *stored = f64::NAN;
        });
        sample.iter_mut().filter(is_nowhere).for_each(|stored| *stored = f64::NAN);
        if !is_settled {
            let kind = if self.header.sample == "uint8" { Values::ByteHeights } else { Values::Heights };
            let test = Test { kind, unit_m: (scale * unit.metres).abs(), limits: limits(self.header.sample) };
            let fills = fill::remove(&mut values, &sample, test);
            nodata.extend(fills.iter().map(|fill| fill.value));
            let values = fills.iter().map(Fill::in_words).collect::<Vec<_>>().join(",");
            remarks.extend(
                fills.into_iter().map(|fill| Remark::SuspectedNodata { fill, values: values.clone() }),
            );
        }
        let cells = interpolated::remove(&mut values, window.width as usize, &was_number, &nodata);
        if cells > 0 {
            remarks.push(Remark::InterpolatedNodata { cells });
        }
        let mut heights_m: Vec<f64> = values.into_iter().map(height_m).collect();
        let scaling = Scaling {
            offset,
            unit_m: unit.metres,
            is_plain: (scale, offset, unit.metres) == (1.0, 0.0, 1.0),
        };
        radii::refuse(&heights_m, system.and_then(|system| system.radius_m), georeference, window, &scaling)?;
        remarks.extend(beyond.remove(&mut heights_m));
        remarks.extend(radii::remark(&heights_m));
        if heights_m.iter().all(|height| height.is_nan()) {
            let why: String = remarks
                .iter()
                .filter(|remark| remark.is_of_nodata())
                .map(|remark| format!("; {remark}"))
                .collect();
            return Err(TerrainError::NoHeights { cells: window.cells(), why });
        }
        Ok(heights_m)
    }

    /// The values within `window`, row-major, southernmost row first. NaN stands for nodata, for cells that a mask leaves out,
    /// for values that are not finite, and for those larger than [`LENGTH_MAX_M`].
    ///
    /// # Errors
    /// If the window is not within the file or too large, or the data cut short or malformed.
    pub fn values(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let mut values = self.cells(window)?;
        let nodata: Vec<f64> =
            self.declared().into_iter().chain(self.settled.iter().flatten().copied()).collect();
        self.clear(&mut values, &nodata);
        Ok(self.scaled(values))
    }

    /// [`RasterFile::values`] of a layer of codes or shares, without those that look like nodata.
    pub(crate) fn layer(&mut self, window: Window) -> Result<(Vec<f64>, Vec<Fill>), TerrainError> {
        let RasterHeader { scale, offset, .. } = self.header;
        let mut values = self.cells(window)?;
        let mut sample = self.sample(window);
        let nodata = self.declared();
        self.clear(&mut values, &nodata);
        self.clear(&mut sample, &nodata);
        let test = Test { kind: Values::Layer, unit_m: 1.0, limits: limits(self.header.sample) };
        let mut fills = fill::remove_beyond(&mut values, &mut sample, |stored| {
            (stored * scale + offset).abs() > LENGTH_MAX_M
        });
        fills.extend(fill::remove(&mut values, &sample, test));
        Ok((self.scaled(values), fills))
    }

    fn scaled(&self, mut values: Vec<f64>) -> Vec<f64> {
        let RasterHeader { scale, offset, .. } = self.header;
        for value in &mut values {
            let scaled = *value * scale + offset;
            *value = if scaled.abs() <= LENGTH_MAX_M { scaled } else { f64::NAN };
        }
        values
    }

    /// The values as they are stored; NaN for cells that a mask leaves out.
    fn cells(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
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
        for (path, mask, reader) in &mut self.masks {
            let counts = mask.values(reader, window).map_err(|error| error.of(path))?;
            geotiff::apply(&mut values, &counts);
        }
        Ok(values)
    }

    /// Values of the whole file, or of parts all over it if it is large; none if `window` is the whole. To be called after
    /// [`RasterFile::cells`]: a file of text is read only once. A part that cannot be read is left out, as nobody asked for it.
    fn sample(&mut self, window: Window) -> Vec<f64> {
        let RasterHeader { width, height, .. } = self.header;
        if window == Window::all(width, height) {
            return Vec::new();
        }
        let parts = match &mut self.source {
            Source::GeoTiff(file) => file.parts(),
            Source::AsciiGrid(file) if self.masks.is_empty() => return std::mem::take(&mut file.sample),
            Source::AsciiGrid(_) => return Vec::new(),
        };
        parts.into_iter().flat_map(|part| self.cells(part).unwrap_or_default()).collect()
    }

    /// The values that the file, or one beside it, declares as nodata.
    fn declared(&self) -> Vec<f64> {
        let declared = [self.header.nodata, self.own_nodata].into_iter().flatten();
        declared.chain(self.further_nodata.iter().copied()).collect()
    }

    /// Puts NaN in the place of `nodata`.
    fn clear(&self, values: &mut [f64], nodata: &[f64]) {
        let is_nodata = |value: f64| nodata.iter().any(|nodata| self.is_same(*nodata, value));
        for value in values.iter_mut().filter(|value| is_nodata(**value)) {
            *value = f64::NAN;
        }
    }

    /// Whether both are one value, as the file stores it. Fractions lose digits on the way through float32, and in the text of
    /// a header.
    fn is_same(&self, one: f64, other: f64) -> bool {
        let has_fractions = ["text", "float32", "float64"].contains(&self.header.sample);
        one == other || has_fractions && one as f32 == other as f32
    }

    /// The stored values that are meant by `settled`, which name them as they are stored or as they are scaled, and those
    /// that no cell holds.
    fn found(&self, settled: &[f64], cells: [&Vec<f64>; 2]) -> (Vec<f64>, Vec<f64>) {
        let RasterHeader { scale, offset, .. } = self.header;
        let known = || cells.iter().flat_map(|values| values.iter().copied());
        let (mut found, mut missing) = (Vec::new(), Vec::new());
        let declared = self.declared();
        for &value in settled {
            let is_stored = |stored: f64| self.is_same(value, stored);
            let is_scaled = |stored: &f64| (*stored * scale + offset) as f32 == value as f32;
            if declared.iter().copied().chain(known()).any(is_stored) {
                found.push(value);
            } else if let Some(stored) = known().find(is_scaled) {
                found.push(stored);
            } else {
                missing.push(value);
            }
        }
        (found, missing)
    }

    /// How a further raster of the cells at `place` lies.
    pub(crate) fn lies(&self, place: &Georeference) -> Result<Lies, TerrainError> {
        let far_m = 1e-3 * place.cell_size_m;
        let side = f64::from(self.header.width.max(self.header.height));
        let is_near = |cell_m: f64, west_m: f64, south_m: f64| {
            let differs =
                [(place.cell_size_m - cell_m) * side, place.west_m - west_m, place.south_m - south_m];
            differs.iter().all(|by_m| by_m.abs() <= far_m)
        };
        let placement = match self.placement() {
            Err(TerrainError::NoGeoreference) => return Ok(Lies::There),
            placement => placement?,
        };
        // Where the raster does not say in which system it is, its numbers are in the unit of the model's.
        let south = placement.north - f64::from(self.header.height - 1) * placement.y_size;
        let [cell_m, west_m, south_m] =
            [placement.x_size, placement.west, south].map(|length| length * place.unit_m);
        if is_near(cell_m, west_m, south_m) && matches!(self.system(), Ok(None)) {
            return Ok(Lies::There);
        }
        let got = self.georeference()?;
        Ok(match got.identity.is_of(&place.identity) {
            _ if !is_near(got.cell_size_m, got.west_m, got.south_m) => Lies::Elsewhere(got),
            Some(true) => Lies::There,
            Some(false) => Lies::InOtherSystem(got),
            None => Lies::MaybeInOtherSystem(got),
        })
    }
}

/// How a further raster lies to the model.
pub(crate) enum Lies {
    /// On the same cells, or it does not say.
    There,
    /// On other cells.
    Elsewhere(Georeference),
    /// On cells of the same numbers in another coordinate system.
    InOtherSystem(Georeference),
    /// On cells of the same numbers, in a system of another name.
    MaybeInOtherSystem(Georeference),
}

/// What two texts say of one raster.
fn together(first: CoordinateSystem, next: CoordinateSystem) -> Result<CoordinateSystem, TerrainError> {
    let is_plane = |system: &CoordinateSystem| system.kind == Some(Kind::Plane);
    if is_plane(&first) && next.kind.is_some() && !is_plane(&next) {
        return Err(TerrainError::Unsupported {
            what: "coordinate system",
            need: "one, in metres",
            got: format!("{} in one place and {} in another", first.name, next.name),
            remedy: "remove the file beside the raster that is wrong, or correct it",
        });
    }
    let unit = match is_plane(&next) {
        true => agreed("unit of coordinates", [first.unit.clone(), next.unit.clone()])?,
        false => first.unit.clone(),
    };
    let heights = Heights {
        unit: agreed("unit of heights", [first.heights.unit.clone(), next.heights.unit.clone()])?,
        downwards: first.heights.downwards || next.heights.downwards,
        maybe_feet: first.heights.maybe_feet.clone().or(next.heights.maybe_feet.clone()),
    };
    let radius_m = first.radius_m.or(next.radius_m);
    let named = if first.kind.is_some() { first } else { next };
    Ok(CoordinateSystem { unit, heights, radius_m, ..named })
}

/// The numbers at the ends of an integer type of 16 bits or more; 0 is none.
fn limits(sample: &str) -> &'static [f64] {
    match sample {
        "int16" => &[-32768.0, 32767.0],
        "uint16" => &[65535.0],
        "int32" => &[-2_147_483_648.0, 2_147_483_647.0],
        "uint32" => &[4_294_967_295.0],
        _ => &[],
    }
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
