//! Reads GeoTIFF elevation models (OGC 19-008): one band, strips or tiles, north-up, with the mask that it may hold.
//!
//! The `tiff` crate (version 0.11.3) is not used: it fails on valid tiled LZW files (image-rs/image-tiff
//! issue 395) and on images of more than some thirty thousand strips, and it allocates what a header claims
//! before this module could check it.

use std::io::{BufRead, Seek, SeekFrom};

use roxmltree::Document;

use crate::geo_keys::GeoKeys;
use crate::number::number;
use crate::raster_header::{PixelIs, Placement, RasterFormat, RasterHeader};
use crate::tiff_directory::Directory;
use crate::tiff_image::{Image, Shows};
use crate::{TerrainError, Window};

/// Most directories that are looked through for a mask: those of overviews and their masks stand among them.
const DIRECTORIES_MAX: usize = 256;

/// How far tie points may be off the lattice, cells.
const TIED_WITHIN: f64 = 1e-3;

/// Flag of a directory that holds the mask of another (TIFF 6.0, NewSubfileType).
const IS_MASK: u64 = 4;

mod tag {
    pub const SUBFILE_TYPE: u16 = 254;
    pub const WIDTH: u16 = 256;
    pub const HEIGHT: u16 = 257;
    pub const PIXEL_SCALE: u16 = 33550;
    pub const TIEPOINT: u16 = 33922;
    pub const TRANSFORMATION: u16 = 34264;
    pub const GEO_KEYS: u16 = 34735;
    pub const GEO_NUMBERS: u16 = 34736;
    pub const GEO_TEXT: u16 = 34737;
    pub const GDAL_METADATA: u16 = 42112;
    pub const GDAL_NODATA: u16 = 42113;
}

pub(crate) struct GeoTiff<R> {
    pub header: RasterHeader,
    pub keys: GeoKeys,
    /// Unit of the values, as GDAL's metadata name it.
    pub unit: Option<String>,
    /// Nodata beside that of the header, as GDAL's metadata name it.
    pub further_nodata: Vec<f64>,
    scale: Option<Vec<f64>>,
    tiepoint: Option<Vec<f64>>,
    transformation: Option<Vec<f64>>,
    image: Image,
    mask: Option<Image>,
    reader: R,
}

impl<R: BufRead + Seek> GeoTiff<R> {
    /// Whether a file that begins with `start` is a TIFF.
    pub fn begins(start: &[u8]) -> bool {
        [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| start.starts_with(*magic))
    }

    /// Reads and checks the tags.
    pub fn open(mut reader: R) -> Result<Self, TerrainError> {
        let length = reader.seek(SeekFrom::End(0))?;
        reader.seek(SeekFrom::Start(0))?;
        let directory = Directory::read(&mut reader)?;
        let text = directory.text(&mut reader, tag::GEO_TEXT, "GeoAsciiParams")?.unwrap_or_default();
        let numbers =
            directory.doubles(&mut reader, tag::GEO_NUMBERS, "GeoDoubleParams")?.unwrap_or_default();
        let keys = match directory.unsigned(&mut reader, tag::GEO_KEYS, "GeoKeyDirectory")? {
            Some(keys) => GeoKeys::new(&keys, &numbers, &text)?,
            None => GeoKeys::default(),
        };
        let scale = directory.doubles(&mut reader, tag::PIXEL_SCALE, "ModelPixelScale")?;
        let tiepoint = directory.doubles(&mut reader, tag::TIEPOINT, "ModelTiepoint")?;
        let transformation = directory.doubles(&mut reader, tag::TRANSFORMATION, "ModelTransformation")?;
        let nodata = nodata(&directory, &mut reader)?;
        let metadata = directory.text(&mut reader, tag::GDAL_METADATA, "GDAL metadata")?.unwrap_or_default();
        let metadata = Metadata::read(&metadata)?;
        let mask = mask(&directory, &mut reader)?;
        let image = Image::open(directory, &mut reader, Shows::Cells, length)?;
        let mask = match mask {
            Some(directory) => Some(Image::open(directory, &mut reader, Shows::Mask, length)?),
            None => None,
        };
        let has_heights = keys.says_of_heights();
        let keyed = if has_heights { of_heights(scale.as_deref(), tiepoint.as_deref())? } else { (1.0, 0.0) };
        let header = RasterHeader {
            format: RasterFormat::Geotiff,
            width: image.width,
            height: image.height,
            sample: image.sample.name(),
            nodata,
            scale: metadata.number("scale", keyed.0)?,
            offset: metadata.number("offset", keyed.1)?,
        };
        let unit = metadata.text("unittype").map(str::to_owned);
        let further_nodata = metadata.nodata_values();
        Ok(Self { header, keys, unit, further_nodata, scale, tiepoint, transformation, image, mask, reader })
    }

    /// Opens a file of a mask: which cells of another raster count.
    pub fn open_mask(mut reader: R) -> Result<(Image, R), TerrainError> {
        let length = reader.seek(SeekFrom::End(0))?;
        reader.seek(SeekFrom::Start(0))?;
        let directory = Directory::read(&mut reader)?;
        Ok((Image::open(directory, &mut reader, Shows::Mask, length)?, reader))
    }

    /// Middle of the north-western cell, from a transformation or from a scale with one tie point.
    ///
    /// Raster coordinates (0, 0) are the outer corner of that cell where a pixel is an area, and its
    /// middle where it is a point.
    pub fn placement(&self) -> Result<Placement, TerrainError> {
        let pixel_is = self.keys.pixel_is();
        let middle = if pixel_is == PixelIs::Area { 0.5 } else { 0.0 };
        if let Some(matrix) = &self.transformation {
            let [a, b, _, d, e, f, _, h, ..] = matrix[..] else {
                return Err(wrong_count("ModelTransformation", 16, matrix.len()));
            };
            if matrix.len() != 16 {
                return Err(wrong_count("ModelTransformation", 16, matrix.len()));
            }
            return Placement::of_transform([d, a, b, h, e, f], middle, pixel_is);
        }
        let (Some(scale), Some(tiepoint)) = (&self.scale, &self.tiepoint) else {
            return Err(TerrainError::NoGeoreference);
        };
        let [x_size, y_size, ..] = scale[..] else {
            return Err(wrong_count("ModelPixelScale", 3, scale.len()));
        };
        let (&[i, j, _, x, y, _], further) = tiepoint
            .split_first_chunk::<6>()
            .filter(|(_, further)| further.len() % 6 == 0)
            .ok_or_else(|| wrong_count("ModelTiepoint", 6, tiepoint.len()))?;
        // Further tie points have to be of the same lattice.
        let is_off = |point: &[f64]| {
            let off = [point[3] - x - (point[0] - i) * x_size, point[4] - y + (point[1] - j) * y_size];
            !(off[0].abs() <= TIED_WITHIN * x_size && off[1].abs() <= TIED_WITHIN * y_size)
        };
        if let Some(point) = further.chunks_exact(6).find(|point| is_off(point)) {
            return Err(TerrainError::NotNorthUp {
                got: format!("tie points such as {point:?} off its lattice"),
            });
        }
        if x_size < 0.0 || y_size < 0.0 {
            return Err(TerrainError::NotNorthUp { got: format!("a pixel scale of {x_size} x {y_size}") });
        }
        Ok(Placement {
            x_size,
            y_size,
            west: x + (middle - i) * x_size,
            north: y - (middle - j) * y_size,
            pixel_is,
        })
    }

    /// Windows all over the file: all of it, or some of its strips or tiles if it is large.
    pub fn parts(&self) -> Vec<Window> {
        self.image.parts()
    }

    /// Stored values within `window`, southernmost row first; NaN for nodata and where the file's own mask says so.
    pub fn values(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let mut values = self.image.values(&mut self.reader, window)?;
        if let Some(mask) = &self.mask {
            let mask = mask.values(&mut self.reader, window)?;
            apply(&mut values, &mask);
        }
        Ok(values)
    }
}

/// Takes the cells out of `values` that the `mask` leaves out: where it is 0, or left out itself.
pub(crate) fn apply(values: &mut [f64], mask: &[f64]) {
    for (value, counts) in values.iter_mut().zip(mask) {
        if *counts == 0.0 || counts.is_nan() {
            *value = f64::NAN;
        }
    }
}

/// The directory with the mask of the first image, if the file has one.
fn mask<R: BufRead + Seek>(first: &Directory, reader: &mut R) -> Result<Option<Directory>, TerrainError> {
    let size = size(first, reader)?;
    let mut next = first.following(reader)?;
    for _ in 0..DIRECTORIES_MAX {
        let Some(directory) = next else { return Ok(None) };
        let flags = directory.single(reader, tag::SUBFILE_TYPE, "kind of a directory")?.unwrap_or(0);
        // Overviews have masks of their own, which are smaller.
        if flags & IS_MASK != 0 && self::size(&directory, reader)? == size {
            return Ok(Some(directory));
        }
        next = directory.following(reader)?;
    }
    Err(TerrainError::Malformed {
        what: "number of TIFF directories",
        need: format!("at most {DIRECTORIES_MAX}"),
        got: "more".into(),
    })
}

/// Scale and offset of heights: where keys tell of a vertical system, the third numbers of pixel scale and tie point are theirs.
fn of_heights(scale: Option<&[f64]>, tiepoint: Option<&[f64]>) -> Result<(f64, f64), TerrainError> {
    let (Some(&[_, _, scale]), Some(&[_, _, from, _, _, to])) = (scale, tiepoint) else {
        return Ok((1.0, 0.0));
    };
    if (scale, from, to) == (0.0, 0.0, 0.0) {
        return Ok((1.0, 0.0));
    }
    let offset = to - from * scale;
    if scale == 0.0 || !scale.is_finite() || !offset.is_finite() {
        return Err(TerrainError::Malformed {
            what: "third number of ModelPixelScale, the scale of heights",
            need: "a finite number other than 0 beside a tie point with a height".into(),
            got: scale.to_string(),
        });
    }
    Ok((scale, offset))
}

/// Columns and rows of the image of a directory.
fn size<R: BufRead + Seek>(directory: &Directory, reader: &mut R) -> Result<[Option<u64>; 2], TerrainError> {
    let width = directory.single(reader, tag::WIDTH, "image width")?;
    Ok([width, directory.single(reader, tag::HEIGHT, "image height")?])
}

fn nodata<R: BufRead + Seek>(directory: &Directory, reader: &mut R) -> Result<Option<f64>, TerrainError> {
    match directory.text(reader, tag::GDAL_NODATA, "GDAL_NODATA")? {
        Some(text) if !text.is_empty() => match number(&text) {
            Some(nodata) => Ok(Some(nodata)),
            None => Err(TerrainError::Malformed {
                what: "GDAL_NODATA",
                need: "a number".into(),
                got: format!("{text:?}"),
            }),
        },
        _ => Ok(None),
    }
}

/// What GDAL notes of the first band, in `<Item name="SCALE" sample="0" role="scale">0.5</Item>`: role and text.
struct Metadata(Vec<(String, String)>);

impl Metadata {
    fn read(text: &str) -> Result<Self, TerrainError> {
        // Other programs put other text there, which is none of ours.
        if !["role", "NODATA_VALUES"].iter().any(|noted| text.contains(noted)) {
            return Ok(Self(Vec::new()));
        }
        let document = Document::parse(text).map_err(|error| TerrainError::Malformed {
            what: "GDAL metadata",
            need: "XML".into(),
            got: error.to_string(),
        })?;
        let items = document.descendants().filter(|node| node.has_tag_name("Item"));
        let of_band = items.filter(|item| item.attribute("sample").is_none_or(|sample| sample.trim() == "0"));
        let noted = of_band.filter_map(|item| {
            let role = item.attribute("role").or(item.attribute("name"))?.trim().to_ascii_lowercase();
            Some((role, item.text().unwrap_or_default().trim().to_owned()))
        });
        Ok(Self(noted.collect()))
    }

    fn text(&self, role: &str) -> Option<&str> {
        let noted = self.0.iter().find(|(noted, text)| noted == role && !text.is_empty());
        noted.map(|(_, text)| text.as_str())
    }

    /// The nodata of the first band, out of `<Item name="NODATA_VALUES">0 0 0</Item>`.
    fn nodata_values(&self) -> Vec<f64> {
        let values = self.text("nodata_values").unwrap_or_default();
        values.split_whitespace().take(1).filter_map(|value| value.parse().ok()).collect()
    }

    fn number(&self, role: &'static str, default: f64) -> Result<f64, TerrainError> {
        let Some(text) = self.text(role) else { return Ok(default) };
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() && (number != 0.0 || role == "offset") => Ok(number),
            _ => Err(TerrainError::Malformed {
                what: "scale or offset in the GDAL metadata",
                need: "a finite number, the scale not 0".into(),
                got: format!("{text:?}"),
            }),
        }
    }
}

fn wrong_count(what: &'static str, need: usize, got: usize) -> TerrainError {
    TerrainError::Malformed { what, need: format!("{need} numbers"), got: got.to_string() }
}
