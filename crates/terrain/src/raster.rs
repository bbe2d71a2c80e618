//! Opens raster files, elevation models and layers, of either format.

mod located;

use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use contract::limits::LENGTH_MAX_M;

use crate::ascii_grid::AsciiGrid;
use crate::crs::CoordinateSystem;
use crate::fill::{self, Kind, Test};
use crate::geotiff::{self, GeoTiff};
use crate::pam::Auxiliary;
use crate::radii::{self, Beyond, RADIUS_MAX_M, Scaling};
use crate::raster_header::{ELEVATION_CELLS_MAX, RasterHeader};
use crate::tiff_image::Image;
use crate::unit::LengthUnit;
use crate::{Elevation, Fill, Georeference, Remark, TerrainError, Window, interpolated, pds_label, sidecar};

pub(crate) use located::Lies;
use located::Located;

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
            let kind = if self.header.sample == "uint8" { Kind::ByteHeights } else { Kind::Heights };
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
        let test = Test { kind: Kind::Layer, unit_m: 1.0, limits: limits(self.header.sample) };
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
