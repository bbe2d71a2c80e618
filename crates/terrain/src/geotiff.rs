//! Reads GeoTIFF elevation models (OGC 19-008): one band, strips or tiles, north-up.
//!
//! The `tiff` crate (version 0.11.3) is not used: it fails on valid tiled LZW files (image-rs/image-tiff
//! issue 395) and on images of more than some thirty thousand strips, and it allocates what a header claims
//! before this module could check it.

use std::io::{BufRead, Read, Seek, SeekFrom};

use crate::geo_keys::GeoKeys;
use crate::raster_header::{ELEVATION_CELLS_MAX, PixelIs, Placement, RasterFormat, RasterHeader};
use crate::tiff_chunk::{Packing, Predictor, Sample, unpack};
use crate::tiff_directory::{Directory, Order};
use crate::{TerrainError, Window};

/// Largest compression ratio of any TIFF compression. A file that claims more cells than its length could hold
/// was cut short, which is detected before memory is allocated for them.
const PACKING_MAX: u64 = 4096;

/// Most cells in the strips or tiles unpacked for one window: some seconds of work.
const UNPACKED_CELLS_MAX: u64 = 1 << 30;

/// Bytes by which a packed strip or tile may exceed its unpacked size: the worst case of any compression.
const PACKED_SLACK: u64 = 1024;

/// GDAL commands that convert unsupported files.
const AS_DEFLATE: &str = "convert it with gdal_translate -co COMPRESS=DEFLATE IN.tif OUT.tif";
const AS_FLOAT32: &str = "convert it with gdal_translate -ot Float32 IN.tif OUT.tif";
const AS_TILES: &str = "rewrite it in tiles: gdal_translate -co TILED=YES IN.tif OUT.tif";
const AS_ONE_BAND: &str = "choose the band with the heights: gdal_translate -b 1 IN.tif OUT.tif";

mod tag {
    pub const WIDTH: u16 = 256;
    pub const HEIGHT: u16 = 257;
    pub const BITS: u16 = 258;
    pub const COMPRESSION: u16 = 259;
    pub const PHOTOMETRIC: u16 = 262;
    pub const STRIP_OFFSETS: u16 = 273;
    pub const BANDS: u16 = 277;
    pub const ROWS_PER_STRIP: u16 = 278;
    pub const STRIP_BYTES: u16 = 279;
    pub const PREDICTOR: u16 = 317;
    pub const TILE_WIDTH: u16 = 322;
    pub const TILE_HEIGHT: u16 = 323;
    pub const TILE_OFFSETS: u16 = 324;
    pub const TILE_BYTES: u16 = 325;
    pub const SAMPLE_FORMAT: u16 = 339;
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
    scale: Option<Vec<f64>>,
    tiepoint: Option<Vec<f64>>,
    transformation: Option<Vec<f64>>,
    layout: Layout,
    directory: Directory,
    reader: R,
}

/// How the cells are stored in the file.
#[derive(Clone, Copy, Debug)]
struct Layout {
    sample: Sample,
    packing: Packing,
    predictor: Predictor,
    order: Order,
    tiled: bool,
    /// Columns and rows of one strip or tile.
    chunk: (u32, u32),
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
        let (header, layout) = header(&directory, &mut reader, length)?;
        let text = directory.text(&mut reader, tag::GEO_TEXT, "GeoAsciiParams")?.unwrap_or_default();
        let numbers =
            directory.doubles(&mut reader, tag::GEO_NUMBERS, "GeoDoubleParams")?.unwrap_or_default();
        let keys = match directory.unsigned(&mut reader, tag::GEO_KEYS, "GeoKeyDirectory")? {
            Some(keys) => GeoKeys::new(&keys, &numbers, &text)?,
            None => GeoKeys::default(),
        };
        Ok(Self {
            header,
            keys,
            scale: directory.doubles(&mut reader, tag::PIXEL_SCALE, "ModelPixelScale")?,
            tiepoint: directory.doubles(&mut reader, tag::TIEPOINT, "ModelTiepoint")?,
            transformation: directory.doubles(&mut reader, tag::TRANSFORMATION, "ModelTransformation")?,
            layout,
            directory,
            reader,
        })
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
            let straight = b == 0.0 && e == 0.0 && a > 0.0 && f < 0.0;
            if !straight {
                return Err(TerrainError::NotNorthUp {
                    got: format!("x = {a} i + {b} j, y = {e} i + {f} j"),
                });
            }
            return Ok(Placement {
                x_size: a,
                y_size: -f,
                west: d + a * middle,
                north: h + f * middle,
                pixel_is,
            });
        }
        let (Some(scale), Some(tiepoint)) = (&self.scale, &self.tiepoint) else {
            return Err(TerrainError::NoGeoreference);
        };
        let [x_size, y_size, ..] = scale[..] else {
            return Err(wrong_count("ModelPixelScale", 3, scale.len()));
        };
        let [i, j, _, x, y, _] = tiepoint[..] else {
            return Err(wrong_count("ModelTiepoint", 6, tiepoint.len()));
        };
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

    /// Stored values within `window`, southernmost row first, NaN for nodata.
    pub fn values(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let RasterHeader { width, height, .. } = self.header;
        let (chunk_width, chunk_height) = self.layout.chunk;
        let chunks_across = width.div_ceil(chunk_width);
        let places = self.places(u64::from(chunks_across) * u64::from(height.div_ceil(chunk_height)))?;
        // Chunks are numbered from the north, window rows from the south.
        let north = height - window.y - window.height;
        let down = north / chunk_height..=(north + window.height - 1) / chunk_height;
        let across = window.x / chunk_width..=(window.x + window.width - 1) / chunk_width;
        let chunks = down.clone().count() as u64 * across.clone().count() as u64;
        let unpacked = chunks.saturating_mul(u64::from(chunk_width) * u64::from(chunk_height));
        if unpacked > UNPACKED_CELLS_MAX {
            return Err(TerrainError::Unsupported {
                what: "cells in the strips or tiles to be unpacked",
                need: "at most 1073741824",
                got: unpacked.to_string(),
                remedy: AS_TILES,
            });
        }
        let mut values = vec![f64::NAN; window.cells() as usize];
        for chunk_y in down {
            for chunk_x in across.clone() {
                let (left, top) = (chunk_x * chunk_width, chunk_y * chunk_height);
                let Some(chunk) = self.chunk(places[(chunk_y * chunks_across + chunk_x) as usize], top)?
                else {
                    continue;
                };
                let columns = left.max(window.x)..(left + chunk_width).min(window.x + window.width);
                let length = (columns.end - columns.start) as usize;
                for row in top.max(north)..(top + chunk_height).min(north + window.height) {
                    let from = ((row - top) * chunk_width + columns.start - left) as usize;
                    let to = (north + window.height - 1 - row) as usize * window.width as usize
                        + (columns.start - window.x) as usize;
                    values[to..to + length].copy_from_slice(&chunk[from..from + length]);
                }
            }
        }
        Ok(values)
    }

    /// Offset and length of every strip or tile.
    fn places(&mut self, count: u64) -> Result<Vec<(u64, u64)>, TerrainError> {
        let (offsets, lengths) = if self.layout.tiled {
            (tag::TILE_OFFSETS, tag::TILE_BYTES)
        } else {
            (tag::STRIP_OFFSETS, tag::STRIP_BYTES)
        };
        let mut numbers = |tag, what| -> Result<Vec<u64>, TerrainError> {
            let numbers = self.directory.unsigned(&mut self.reader, tag, what)?.unwrap_or_default();
            if numbers.len() as u64 == count {
                Ok(numbers)
            } else {
                Err(TerrainError::Malformed { what, need: count.to_string(), got: numbers.len().to_string() })
            }
        };
        let offsets = numbers(offsets, "offsets of strips or tiles")?;
        Ok(offsets.into_iter().zip(numbers(lengths, "lengths of strips or tiles")?).collect())
    }

    /// The values of the strip or tile at `place` whose first row is `top`; NaN for nodata, which is compared in
    /// the sample type it was stored in. `None` if the file leaves the chunk out, as GDAL does with chunks of
    /// nodata.
    fn chunk(&mut self, place: (u64, u64), top: u32) -> Result<Option<Vec<f64>>, TerrainError> {
        let (offset, length) = place;
        if length == 0 {
            return Ok(None);
        }
        let Layout { sample, packing, predictor, order, tiled, chunk: (columns, rows) } = self.layout;
        // Tiles are padded to their full size, strips end with the last row.
        let rows = if tiled { rows } else { rows.min(self.header.height - top) };
        let row_bytes = columns as usize * sample.size();
        let unpacked_length = row_bytes * rows as usize;
        if length > 2 * unpacked_length as u64 + PACKED_SLACK {
            return Err(TerrainError::Malformed {
                what: "length of a strip or tile",
                need: format!(
                    "at most {} bytes for {unpacked_length} bytes unpacked",
                    2 * unpacked_length as u64 + PACKED_SLACK
                ),
                got: length.to_string(),
            });
        }
        self.reader.seek(SeekFrom::Start(offset))?;
        let mut packed = Vec::new();
        (&mut self.reader).take(length).read_to_end(&mut packed)?;
        if (packed.len() as u64) < length {
            return Err(TerrainError::Truncated { need: "the cells that the header announces".into() });
        }
        let mut bytes = unpack(&packed, packing, unpacked_length)?;
        let nodata = self.header.nodata.map(|nodata| sample.stored(nodata));
        let mut values = Vec::with_capacity(unpacked_length / sample.size());
        for row in bytes.chunks_exact_mut(row_bytes) {
            predictor.undo(row, sample, order, |value| {
                values.push(if Some(value) == nodata { f64::NAN } else { value });
            });
        }
        Ok(Some(values))
    }
}

/// The tags that decide how the cells are encoded, as numbers.
struct Encoding {
    width: u32,
    height: u32,
    bands: u64,
    bits: u64,
    sample_format: u64,
    compression: u64,
    predictor: u64,
    photometric: u64,
    rows_per_strip: u64,
}

/// Reads and checks every tag that decides the type of the cells and how much memory they take.
fn header<R: BufRead + Seek>(
    directory: &Directory,
    reader: &mut R,
    file_bytes: u64,
) -> Result<(RasterHeader, Layout), TerrainError> {
    let encoding = Encoding::read(directory, reader)?;
    let (packing, sample, predictor) = encoding.supported()?;
    let Encoding { width, height, bits, .. } = encoding;
    let tiled = directory.has(tag::TILE_WIDTH);
    let (chunk_width, chunk_height) = if tiled {
        let width = number(directory, reader, tag::TILE_WIDTH, "tile width", None)?;
        (width, number(directory, reader, tag::TILE_HEIGHT, "tile height", None)?)
    } else {
        (u64::from(width), encoding.rows_per_strip.min(u64::from(height)))
    };
    let chunk_cells = chunk_cells(chunk_width, chunk_height)?;
    let bytes = (u64::from(width) * u64::from(height)).max(chunk_cells).saturating_mul(bits / 8);
    if bytes / PACKING_MAX > file_bytes {
        return Err(TerrainError::Truncated {
            need: format!("{width} x {height} cells of {}", sample.name()),
        });
    }
    let nodata = nodata(directory, reader)?;
    let metadata = directory.text(reader, tag::GDAL_METADATA, "GDAL metadata")?.unwrap_or_default();
    let header = RasterHeader {
        format: RasterFormat::Geotiff,
        width,
        height,
        sample: sample.name(),
        nodata,
        scale: metadata_number(&metadata, "scale", 1.0)?,
        offset: metadata_number(&metadata, "offset", 0.0)?,
    };
    let chunk = (chunk_width as u32, chunk_height as u32);
    Ok((header, Layout { sample, packing, predictor, order: directory.order, tiled, chunk }))
}

impl Encoding {
    fn read<R: BufRead + Seek>(directory: &Directory, reader: &mut R) -> Result<Self, TerrainError> {
        let mut number = |tag, what, default| number(directory, reader, tag, what, default);
        let width = side("image width", number(tag::WIDTH, "image width", None)?)?;
        let height = side("image height", number(tag::HEIGHT, "image height", None)?)?;
        Ok(Self {
            width,
            height,
            bands: number(tag::BANDS, "bands", Some(1))?,
            bits: number(tag::BITS, "bits of a sample", Some(1))?,
            sample_format: number(tag::SAMPLE_FORMAT, "sample format", Some(1))?,
            compression: number(tag::COMPRESSION, "compression", Some(1))?,
            predictor: number(tag::PREDICTOR, "predictor", Some(1))?,
            photometric: number(tag::PHOTOMETRIC, "photometric interpretation", None)?,
            rows_per_strip: number(tag::ROWS_PER_STRIP, "rows per strip", Some(u64::from(height)))?,
        })
    }

    /// Compression, sample type and predictor, if all of them are read here.
    fn supported(&self) -> Result<(Packing, Sample, Predictor), TerrainError> {
        let unsupported = |what, need, got: u64, remedy| {
            Err(TerrainError::Unsupported { what, need, got: got.to_string(), remedy })
        };
        if self.bands != 1 {
            return unsupported("bands", "one", self.bands, AS_ONE_BAND);
        }
        if self.photometric != 1 {
            let need = "1 (black is zero); other images are pictures, not heights";
            return unsupported("photometric interpretation", need, self.photometric, AS_ONE_BAND);
        }
        let Some(packing) = Packing::of_code(self.compression) else {
            let need = "none, LZW, deflate or PackBits";
            return unsupported("compression", need, self.compression, AS_DEFLATE);
        };
        let Some(sample) = Sample::of_codes(self.sample_format, self.bits) else {
            return Err(TerrainError::Unsupported {
                what: "sample type",
                need: "integers of 8, 16 or 32 bits or floating point of 32 or 64",
                got: format!("format {} of {} bits", self.sample_format, self.bits),
                remedy: AS_FLOAT32,
            });
        };
        let Some(predictor) = Predictor::of_code(self.predictor, packing, sample) else {
            let need = "1, or with LZW or deflate 2, or 3 for floating point";
            return unsupported("predictor", need, self.predictor, AS_DEFLATE);
        };
        Ok((packing, sample, predictor))
    }
}

/// The unsigned integer of `tag`, or `default` if the directory lacks it.
fn number<R: BufRead + Seek>(
    directory: &Directory,
    reader: &mut R,
    tag: u16,
    what: &'static str,
    default: Option<u64>,
) -> Result<u64, TerrainError> {
    directory.single(reader, tag, what)?.or(default).ok_or_else(|| TerrainError::Malformed {
        what,
        need: "a value".into(),
        got: "none".into(),
    })
}

/// Cells of one strip or tile, if they are at least one and no more than fit into memory.
fn chunk_cells(chunk_width: u64, chunk_height: u64) -> Result<u64, TerrainError> {
    if chunk_width == 0 || chunk_height == 0 {
        let got = format!("{chunk_width} x {chunk_height}");
        return Err(TerrainError::Malformed { what: "strip or tile", need: "cells".into(), got });
    }
    let cells = chunk_width.saturating_mul(chunk_height);
    if cells > ELEVATION_CELLS_MAX {
        return Err(TerrainError::Unsupported {
            what: "cells in a strip or tile",
            need: "at most 16777216",
            got: cells.to_string(),
            remedy: AS_TILES,
        });
    }
    Ok(cells)
}

fn nodata<R: BufRead + Seek>(directory: &Directory, reader: &mut R) -> Result<Option<f64>, TerrainError> {
    match directory.text(reader, tag::GDAL_NODATA, "GDAL_NODATA")? {
        Some(text) if !text.is_empty() => text.parse().map(Some).map_err(|_| TerrainError::Malformed {
            what: "GDAL_NODATA",
            need: "a number".into(),
            got: format!("{text:?}"),
        }),
        _ => Ok(None),
    }
}

fn side(what: &'static str, got: u64) -> Result<u32, TerrainError> {
    match u32::try_from(got) {
        Ok(side) if (1..=i32::MAX as u32).contains(&side) => Ok(side),
        _ => Err(TerrainError::Malformed { what, need: format!("1 to {}", i32::MAX), got: got.to_string() }),
    }
}

/// GDAL keeps scale and offset of stored heights in `<Item ... role="scale">0.5</Item>`.
fn metadata_number(metadata: &str, role: &'static str, default: f64) -> Result<f64, TerrainError> {
    let Some((_, rest)) = metadata.split_once(&format!("role=\"{role}\"")) else { return Ok(default) };
    let text = rest.split_once('>').and_then(|(_, rest)| rest.split_once('<')).map_or("", |(text, _)| text);
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() && (number != 0.0 || role == "offset") => Ok(number),
        _ => Err(TerrainError::Malformed {
            what: "scale or offset in the GDAL metadata",
            need: "a finite number, the scale not 0".into(),
            got: format!("{text:?}"),
        }),
    }
}

fn wrong_count(what: &'static str, need: usize, got: usize) -> TerrainError {
    TerrainError::Malformed { what, need: format!("{need} numbers"), got: got.to_string() }
}
