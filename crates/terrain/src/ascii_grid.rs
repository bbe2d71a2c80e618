//! Reads ESRI ASCII grids: a header of keywords, then the rows, northernmost first.
//!
//! The `esri_ascii_grid` crate (version 0.4.6) is not used: it panics on a header of 0 rows or on a value
//! that is not a number, allocates as many rows as the header claims, accepts one order of the header only,
//! and loses the first row of a file without a NODATA_value line.

use std::io::{BufRead, Seek};

use crate::raster_header::{PixelIs, Placement, RasterFormat, RasterHeader};
use crate::{TerrainError, Window};

/// Longest word of a grid, bytes.
const WORD_BYTES_MAX: usize = 64;

pub(crate) struct AsciiGrid<R> {
    pub header: RasterHeader,
    cell_sizes: [f64; 2],
    /// Easting and northing of the south-western cell: its corner or its middle, as `pixel_is` says.
    origin: [f64; 2],
    pixel_is: PixelIs,
    words: Words<R>,
    /// The first value: reading it ended the header.
    first: Option<String>,
}

impl<R: BufRead + Seek> AsciiGrid<R> {
    /// Whether a file that begins with `start` looks like an ASCII grid.
    pub fn begins(start: &[u8]) -> bool {
        let word = start.trim_ascii_start().to_ascii_lowercase();
        ["ncols", "nrows", "xll", "yll", "cellsize", "dx", "dy", "nodata"]
            .iter()
            .any(|keyword| word.starts_with(keyword.as_bytes()))
    }

    /// Reads the header: keywords with a value each, in any order, until a number appears in place of a
    /// keyword.
    pub fn open(reader: R) -> Result<Self, TerrainError> {
        let mut words = Words { reader };
        let (mut columns, mut rows, mut x, mut y) = (None, None, None, None);
        let (mut cell_x, mut cell_y, mut nodata, mut first) = (None, None, None, None);
        while let Some(keyword) = words.next()? {
            if keyword.parse::<f64>().is_ok() {
                first = Some(keyword);
                break;
            }
            let value = words
                .next()?
                .ok_or_else(|| TerrainError::Truncated { need: format!("a value after {keyword}") })?;
            let number = value.parse::<f64>().map_err(|_| TerrainError::Malformed {
                what: "header of the ASCII grid",
                need: format!("a number after {keyword:?}"),
                got: format!("{value:?}"),
            })?;
            match keyword.to_ascii_lowercase().as_str() {
                "ncols" => columns = Some(side("ncols", &value)?),
                "nrows" => rows = Some(side("nrows", &value)?),
                "xllcorner" => x = Some((number, PixelIs::Area)),
                "yllcorner" => y = Some((number, PixelIs::Area)),
                "xllcenter" | "xllcentre" => x = Some((number, PixelIs::Point)),
                "yllcenter" | "yllcentre" => y = Some((number, PixelIs::Point)),
                "cellsize" => (cell_x, cell_y) = (Some(number), Some(number)),
                "dx" => cell_x = Some(number),
                "dy" => cell_y = Some(number),
                "nodata_value" | "nodata" => nodata = Some(number),
                _ => {
                    return Err(TerrainError::Malformed {
                        what: "header of the ASCII grid",
                        need: "ncols, nrows, xllcorner, yllcorner, cellsize or NODATA_value".into(),
                        got: format!("{keyword:?}"),
                    });
                }
            }
        }
        let (width, height) = (required("ncols", columns)?, required("nrows", rows)?);
        let ((x, x_is), (y, y_is)) = (required("xllcorner", x)?, required("yllcorner", y)?);
        if x_is != y_is {
            return Err(TerrainError::Malformed {
                what: "header of the ASCII grid",
                need: "corners or centres for both axes".into(),
                got: "one of each".into(),
            });
        }
        Ok(Self {
            header: RasterHeader {
                format: RasterFormat::AsciiGrid,
                width,
                height,
                sample: "text",
                nodata,
                scale: 1.0,
                offset: 0.0,
            },
            cell_sizes: [required("cellsize", cell_x)?, required("cellsize", cell_y)?],
            origin: [x, y],
            pixel_is: x_is,
            words,
            first,
        })
    }

    pub fn placement(&self) -> Placement {
        let [x_size, y_size] = self.cell_sizes;
        let middle = if self.pixel_is == PixelIs::Area { 0.5 } else { 0.0 };
        Placement {
            x_size,
            y_size,
            west: self.origin[0] + middle * x_size,
            north: self.origin[1] + (f64::from(self.header.height - 1) + middle) * y_size,
            pixel_is: self.pixel_is,
        }
    }

    /// Values within `window`, southernmost row first, NaN for nodata. Reads and checks every value of the
    /// file, so it can be called only once.
    pub fn values(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let RasterHeader { width, height, nodata, .. } = self.header;
        // Grows as rows arrive: a header cannot make it allocate more than the rows fill.
        let mut north_first = Vec::new();
        for row in 0..height {
            let y = height - 1 - row;
            let inside_y = (window.y..window.y + window.height).contains(&y);
            for x in 0..width {
                let word = match self.first.take() {
                    Some(first) => first,
                    None => self.words.next()?.ok_or_else(|| TerrainError::Truncated {
                        need: format!("{height} rows of {width} values, column {x} of row {row}"),
                    })?,
                };
                let value = word.parse::<f64>().map_err(|_| TerrainError::Malformed {
                    what: "value of the ASCII grid",
                    need: format!("a number in column {x} of row {row}"),
                    got: format!("{word:?}"),
                })?;
                if inside_y && (window.x..window.x + window.width).contains(&x) {
                    north_first.push(if Some(value) == nodata { f64::NAN } else { value });
                }
            }
        }
        if let Some(word) = self.words.next()? {
            return Err(TerrainError::Malformed {
                what: "end of the ASCII grid",
                need: format!("nothing after {height} rows of {width} values"),
                got: format!("{word:?}"),
            });
        }
        Ok(north_first.chunks(window.width as usize).rev().flatten().copied().collect())
    }
}

fn side(what: &'static str, text: &str) -> Result<u32, TerrainError> {
    text.parse().ok().filter(|side| (1..=i32::MAX as u32).contains(side)).ok_or_else(|| {
        TerrainError::Malformed { what, need: format!("1 to {}", i32::MAX), got: format!("{text:?}") }
    })
}

fn required<T>(what: &'static str, value: Option<T>) -> Result<T, TerrainError> {
    value.ok_or_else(|| TerrainError::Malformed {
        what: "header of the ASCII grid",
        need: what.into(),
        got: "none".into(),
    })
}

/// Splits a reader into words at white space, none longer than [`WORD_BYTES_MAX`].
struct Words<R> {
    reader: R,
}

impl<R: BufRead> Words<R> {
    fn next(&mut self) -> Result<Option<String>, TerrainError> {
        let mut word = Vec::new();
        loop {
            let buffer = self.reader.fill_buf()?;
            if buffer.is_empty() {
                break;
            }
            let skipped = if word.is_empty() {
                buffer.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(buffer.len())
            } else {
                0
            };
            let length =
                buffer[skipped..].iter().position(u8::is_ascii_whitespace).unwrap_or(buffer.len() - skipped);
            let ended = skipped + length < buffer.len();
            let taken = length.min(WORD_BYTES_MAX + 1);
            word.extend_from_slice(&buffer[skipped..skipped + taken]);
            self.reader.consume(skipped + length);
            if word.len() > WORD_BYTES_MAX {
                return Err(TerrainError::Malformed {
                    what: "word of the ASCII grid",
                    need: format!("at most {WORD_BYTES_MAX} characters"),
                    got: format!("{}...", word[..16].escape_ascii()),
                });
            }
            if ended {
                break;
            }
        }
        Ok((!word.is_empty()).then(|| String::from_utf8_lossy(&word).into_owned()))
    }
}
