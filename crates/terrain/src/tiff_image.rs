//! The cells of one directory of a TIFF: an image, or the mask of one.

use std::io::{BufRead, Read, Seek, SeekFrom};

use crate::raster_header::ELEVATION_CELLS_MAX;
use crate::tiff_chunk::{Packing, Predictor, Sample, unpack};
use crate::tiff_directory::{Directory, Order};
use crate::{TerrainError, Window};

/// Largest compression ratio of any TIFF compression. A file that claims more cells than its length could hold
/// was cut short, which is detected before memory is allocated for them.
const PACKING_MAX: u64 = 4096;

/// Most cells in the strips or tiles unpacked for one window: some seconds of work.
const UNPACKED_CELLS_MAX: u64 = 1 << 30;

/// Most cells of a file that are read to judge what its values are.
const SAMPLE_CELLS_MAX: u64 = 1 << 22;

/// Most strips or tiles that these are taken from.
const SAMPLE_PARTS_MAX: u64 = 256;

/// Bytes by which a packed strip or tile may exceed its unpacked size: the worst case of any compression.
const PACKED_SLACK: u64 = 1024;

/// GDAL commands that convert unsupported files.
const AS_DEFLATE: &str = "convert it with gdal_translate -co COMPRESS=DEFLATE IN.tif OUT.tif, as --convert does for an elevation model";
const AS_FLOAT32: &str =
    "convert it with gdal_translate -ot Float32 IN.tif OUT.tif, as --convert does for an elevation model";
const AS_TILES: &str = "rewrite it in tiles: gdal_translate -co TILED=YES IN.tif OUT.tif";
const AS_ONE_BAND: &str = "choose the band with the heights: gdal_translate -b 1 IN.tif OUT.tif";
const AS_GREY: &str = "if its numbers are heights all the same: gdal_translate -colorinterp gray -co \
                       PHOTOMETRIC=MINISBLACK IN.tif OUT.tif";
const AS_MASK: &str = "make a mask of the second: gdal_translate -b 1 -mask 2 IN.tif OUT.tif";

mod tag {
    pub const WIDTH: u16 = 256;
    pub const HEIGHT: u16 = 257;
    pub const BITS: u16 = 258;
    pub const COMPRESSION: u16 = 259;
    pub const PHOTOMETRIC: u16 = 262;
    pub const FILL_ORDER: u16 = 266;
    pub const STRIP_OFFSETS: u16 = 273;
    pub const BANDS: u16 = 277;
    pub const ROWS_PER_STRIP: u16 = 278;
    pub const STRIP_BYTES: u16 = 279;
    pub const PREDICTOR: u16 = 317;
    pub const TILE_WIDTH: u16 = 322;
    pub const TILE_HEIGHT: u16 = 323;
    pub const TILE_OFFSETS: u16 = 324;
    pub const TILE_BYTES: u16 = 325;
    pub const EXTRA_BANDS: u16 = 338;
    pub const SAMPLE_FORMAT: u16 = 339;
}

/// What an image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shows {
    /// Heights, or another quantity of each cell.
    Cells,
    /// Which cells of another image count: not 0 where they do.
    Mask,
}

/// The cells of one directory, unread.
pub(crate) struct Image {
    pub width: u32,
    pub height: u32,
    pub sample: Sample,
    layout: Layout,
    directory: Directory,
}

/// How the cells are stored in the file.
#[derive(Clone, Copy, Debug)]
struct Layout {
    packing: Packing,
    predictor: Predictor,
    order: Order,
    tiled: bool,
    /// Columns and rows of one strip or tile.
    chunk: (u32, u32),
}

impl Image {
    /// Reads and checks the tags of `directory`, in a file of `file_bytes`.
    pub fn open<R: BufRead + Seek>(
        directory: Directory,
        reader: &mut R,
        shows: Shows,
        file_bytes: u64,
    ) -> Result<Self, TerrainError> {
        let encoding = Encoding::read(&directory, reader)?;
        let (packing, sample, predictor) = encoding.supported(shows)?;
        let Encoding { width, height, .. } = encoding;
        let tiled = directory.has(tag::TILE_WIDTH);
        let (chunk_width, chunk_height) = if tiled {
            let width = number(&directory, reader, tag::TILE_WIDTH, "tile width", None)?;
            (width, number(&directory, reader, tag::TILE_HEIGHT, "tile height", None)?)
        } else {
            (u64::from(width), encoding.rows_per_strip.min(u64::from(height)))
        };
        let chunk_cells = chunk_cells(chunk_width, chunk_height)?;
        let cells = (u64::from(width) * u64::from(height)).max(chunk_cells);
        let is_too_short =
            |cells: u64| cells.saturating_mul(sample.bits() as u64) / 8 / PACKING_MAX > file_bytes;
        let chunk = (chunk_width as u32, chunk_height as u32);
        let layout = Layout { packing, predictor, order: directory.order, tiled, chunk };
        let image = Self { width, height, sample, layout, directory };
        // Strips and tiles that are left out take no room.
        if is_too_short(cells) && image.stored_cells(reader).map_or(true, is_too_short) {
            return Err(TerrainError::Truncated {
                need: format!("{width} x {height} cells of {}", sample.name()),
            });
        }
        Ok(image)
    }

    /// Cells of the strips or tiles that the file holds.
    fn stored_cells<R: BufRead + Seek>(&self, reader: &mut R) -> Result<u64, TerrainError> {
        let (columns, rows) = self.layout.chunk;
        let chunks = u64::from(self.width.div_ceil(columns)) * u64::from(self.height.div_ceil(rows));
        let held = self.places(reader, chunks)?.iter().filter(|place| place.1 > 0).count() as u64;
        Ok(held * u64::from(columns) * u64::from(rows))
    }

    /// Windows all over the image: all of it, or some of its strips or tiles, evenly spread, if it is large.
    pub fn parts(&self) -> Vec<Window> {
        let Self { width, height, .. } = *self;
        if u64::from(width) * u64::from(height) <= SAMPLE_CELLS_MAX {
            return vec![Window::all(width, height)];
        }
        let (columns, rows) = self.layout.chunk;
        let (across, down) = (u64::from(width.div_ceil(columns)), u64::from(height.div_ceil(rows)));
        let wanted = (SAMPLE_CELLS_MAX / (u64::from(columns) * u64::from(rows))).clamp(1, SAMPLE_PARTS_MAX);
        let parts = wanted.min(across * down);
        (0..parts)
            .map(|part| {
                // The golden ratio spreads them over the columns, whatever the number of these.
                let index = (2 * part + 1) * across * down / (2 * parts);
                let shifted = (part as f64 * 0.618_033_988_749_895).fract();
                let (chunk_x, chunk_y) = match across {
                    1 => (0, index),
                    _ => ((shifted * across as f64) as u64, index / across),
                };
                let (left, top) = (chunk_x as u32 * columns, chunk_y as u32 * rows);
                let (columns, rows) = (columns.min(width - left), rows.min(height - top));
                Window { x: left, y: height - top - rows, width: columns, height: rows }
            })
            .collect()
    }

    /// Stored values within `window`, southernmost row first; NaN where the file leaves strips or tiles out, as GDAL does
    /// with those of nodata.
    pub fn values<R: BufRead + Seek>(
        &self,
        reader: &mut R,
        window: Window,
    ) -> Result<Vec<f64>, TerrainError> {
        let Self { width, height, .. } = *self;
        let (chunk_width, chunk_height) = self.layout.chunk;
        let chunks_across = width.div_ceil(chunk_width);
        let places =
            self.places(reader, u64::from(chunks_across) * u64::from(height.div_ceil(chunk_height)))?;
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
                let Some(chunk) =
                    self.chunk(reader, places[(chunk_y * chunks_across + chunk_x) as usize], top)?
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
    fn places<R: BufRead + Seek>(&self, reader: &mut R, count: u64) -> Result<Vec<(u64, u64)>, TerrainError> {
        let (offsets, lengths) = if self.layout.tiled {
            (tag::TILE_OFFSETS, tag::TILE_BYTES)
        } else {
            (tag::STRIP_OFFSETS, tag::STRIP_BYTES)
        };
        let mut numbers = |tag, what| -> Result<Vec<u64>, TerrainError> {
            let numbers = self.directory.unsigned(reader, tag, what)?.unwrap_or_default();
            if numbers.len() as u64 == count {
                Ok(numbers)
            } else {
                Err(TerrainError::Malformed { what, need: count.to_string(), got: numbers.len().to_string() })
            }
        };
        let offsets = numbers(offsets, "offsets of strips or tiles")?;
        Ok(offsets.into_iter().zip(numbers(lengths, "lengths of strips or tiles")?).collect())
    }

    /// The values of the strip or tile at `place` whose first row is `top`; `None` if the file leaves it out.
    fn chunk<R: BufRead + Seek>(
        &self,
        reader: &mut R,
        place: (u64, u64),
        top: u32,
    ) -> Result<Option<Vec<f64>>, TerrainError> {
        let (offset, length) = place;
        if length == 0 {
            return Ok(None);
        }
        let Layout { packing, predictor, order, tiled, chunk: (columns, rows) } = self.layout;
        // Tiles are padded to their full size, strips end with the last row.
        let rows = if tiled { rows } else { rows.min(self.height - top) };
        let row_bytes = self.sample.row_bytes(columns as usize);
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
        reader.seek(SeekFrom::Start(offset))?;
        let mut packed = Vec::new();
        reader.take(length).read_to_end(&mut packed)?;
        if (packed.len() as u64) < length {
            return Err(TerrainError::Truncated { need: "the cells that the header announces".into() });
        }
        let mut bytes = unpack(&packed, packing, unpacked_length)?;
        let mut values = Vec::with_capacity(columns as usize * rows as usize);
        for row in bytes.chunks_exact_mut(row_bytes) {
            let columns = values.len() + columns as usize;
            predictor.undo(row, self.sample, order, |value| values.push(value));
            values.truncate(columns);
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
    /// 2 where the bits of a byte are written from the lowest on.
    fill_order: u64,
    /// Whether a band beside the first says which cells count.
    has_alpha: bool,
    rows_per_strip: u64,
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
            fill_order: number(tag::FILL_ORDER, "fill order", Some(1))?,
            has_alpha: matches!(number(tag::EXTRA_BANDS, "extra bands", Some(0))?, 1 | 2),
            rows_per_strip: number(tag::ROWS_PER_STRIP, "rows per strip", Some(u64::from(height)))?,
        })
    }

    /// Compression, sample type and predictor, if all of them are read here.
    fn supported(&self, shows: Shows) -> Result<(Packing, Sample, Predictor), TerrainError> {
        let unsupported = |what, need, got: u64, remedy| {
            Err(TerrainError::Unsupported { what, need, got: got.to_string(), remedy })
        };
        if self.bands != 1 {
            let remedy = if self.has_alpha && self.bands == 2 { AS_MASK } else { AS_ONE_BAND };
            return unsupported("bands", "one", self.bands, remedy);
        }
        if shows == Shows::Cells && self.photometric != 1 {
            let need = "1 (black is zero); other images are pictures, not heights";
            return unsupported("photometric interpretation", need, self.photometric, AS_GREY);
        }
        let Some(packing) = Packing::of_code(self.compression) else {
            let need = "none, LZW, deflate or PackBits";
            return unsupported("compression", need, self.compression, AS_DEFLATE);
        };
        let sample = Sample::of_codes(self.sample_format, self.bits);
        let is_right =
            |sample: &Sample| shows == Shows::Mask && self.fill_order == 1 || *sample != Sample::Bit;
        let Some(sample) = sample.filter(is_right) else {
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

fn side(what: &'static str, got: u64) -> Result<u32, TerrainError> {
    match u32::try_from(got) {
        Ok(side) if (1..=i32::MAX as u32).contains(&side) => Ok(side),
        _ => Err(TerrainError::Malformed { what, need: format!("1 to {}", i32::MAX), got: got.to_string() }),
    }
}
