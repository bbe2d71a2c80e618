//! Reads ESRI ASCII grids: a header of keywords, then the rows, northernmost first.
//!
//! The `esri_ascii_grid` crate (version 0.4.6) is not used: it panics on a header of 0 rows or on a value
//! that is not a number, allocates as many rows as the header claims, accepts one order of the header only,
//! and loses the first row of a file without a NODATA_value line.

use std::io::{BufRead, Read as _, Seek, SeekFrom};

use crate::number::number;
use crate::raster_header::{PixelIs, Placement, RasterFormat, RasterHeader};
use crate::{TerrainError, Window};

/// Longest word of a grid, bytes.
const WORD_BYTES_MAX: usize = 64;

/// Most values of a file that are kept to judge what they are.
const SAMPLE_CELLS_MAX: u64 = 1 << 22;

/// Mark that some programs put in front of text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

pub(crate) struct AsciiGrid<R> {
    pub header: RasterHeader,
    /// Whether a byte order mark stood in front.
    pub has_mark: bool,
    cell_sizes: [f64; 2],
    /// Easting and northing of the south-western cell: its corner or its middle, as `pixel_is` says.
    origin: [f64; 2],
    pixel_is: PixelIs,
    words: Words<R>,
    /// The first value: reading it ended the header.
    first: Option<String>,
    /// Values from all over the file, once it is read.
    pub sample: Vec<f64>,
}

impl<R: BufRead + Seek> AsciiGrid<R> {
    /// Whether a file that begins with `start` is an ASCII grid in UTF-16, which is not read.
    pub fn begins_in_utf16(start: &[u8]) -> bool {
        let text = crate::sidecar::decoded(start);
        let plain: Vec<u8> = start.iter().copied().filter(|byte| *byte != 0).collect();
        let has_zeros = start.iter().skip(1).step_by(2).all(|byte| *byte == 0)
            || start.iter().step_by(2).all(|byte| *byte == 0);
        start.len() > 3
            && (matches!(start, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) && Self::begins(text.as_bytes())
                || has_zeros && Self::begins(&plain))
    }

    /// Whether a file that begins with `start` looks like an ASCII grid.
    pub fn begins(start: &[u8]) -> bool {
        let start = start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start);
        let word = start.trim_ascii_start().to_ascii_lowercase();
        ["ncols", "nrows", "xll", "yll", "cellsize", "dx", "dy", "nodata"]
            .iter()
            .any(|keyword| word.starts_with(keyword.as_bytes()))
    }

    /// Reads the header: keywords with a value each, in any order, until a number appears in place of a
    /// keyword.
    // Long: a case for each word that may stand in a header.
    pub fn open(mut reader: R) -> Result<Self, TerrainError> {
        let mut start = Vec::new();
        (&mut reader).take(BYTE_ORDER_MARK.len() as u64).read_to_end(&mut start)?;
        let has_mark = start == BYTE_ORDER_MARK;
        if !has_mark {
            reader.seek(SeekFrom::Start(0))?;
        }
        let mut words = Words { reader };
        let (mut columns, mut rows, mut x, mut y) = (None, None, None, None);
        let (mut cell_x, mut cell_y, mut nodata, mut first) = (None, None, None, None);
        let mut keywords: Vec<String> = Vec::new();
        while let Some(keyword) = words.next()? {
            if number(&keyword).is_some() {
                first = Some(keyword);
                break;
            }
            if let Some(cause) = foreign(&keyword) {
                return Err(cause);
            }
            if !keyword.starts_with(|c: char| c.is_ascii_alphabetic() || "#/".contains(c)) {
                return Err(TerrainError::Malformed {
                    what: "first value of the ASCII grid",
                    need: "a number".into(),
                    got: format!("{keyword:?}"),
                });
            }
            let value = words
                .next()?
                .ok_or_else(|| TerrainError::Truncated { need: format!("a value after {keyword}") })?;
            let number = number(&value).ok_or_else(|| {
                foreign(&value).unwrap_or_else(|| TerrainError::Malformed {
                    what: "header of the ASCII grid",
                    need: format!("a number after {keyword:?}"),
                    got: format!("{value:?}"),
                })
            })?;
            let plain = keyword.to_ascii_lowercase();
            if keywords.contains(&plain) {
                return Err(TerrainError::Malformed {
                    what: "header of the ASCII grid",
                    need: "every keyword once".into(),
                    got: format!("{keyword:?} twice"),
                });
            }
            keywords.push(plain.clone());
            match plain.as_str() {
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
            has_mark,
            cell_sizes: [required("cellsize", cell_x)?, required("cellsize", cell_y)?],
            origin: [x, y],
            pixel_is: x_is,
            words,
            first,
            sample: Vec::new(),
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

    /// Values within `window`, southernmost row first. Reads and checks every value of the file, so it can be called only
    /// once.
    pub fn values(&mut self, window: Window) -> Result<Vec<f64>, TerrainError> {
        let RasterHeader { width, height, .. } = self.header;
        // Grows as rows arrive: a header cannot make it allocate more than the rows fill.
        let mut north_first = Vec::new();
        let is_part = window != Window::all(width, height);
        let step = (u64::from(width) * u64::from(height)).div_ceil(SAMPLE_CELLS_MAX);
        let mut index = 0_u64;
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
                let value = number(&word).ok_or_else(|| {
                    if Self::begins(word.as_bytes()) {
                        return TerrainError::Malformed {
                            what: "header of the ASCII grid",
                            need: format!("one number after the keyword before {word:?}"),
                            got: "several".into(),
                        };
                    }
                    foreign(&word).unwrap_or_else(|| TerrainError::Malformed {
                        what: "value of the ASCII grid",
                        need: format!("a number in column {x} of row {row}"),
                        got: format!("{word:?}"),
                    })
                })?;
                if is_part && index.is_multiple_of(step) {
                    self.sample.push(value);
                }
                index += 1;
                if inside_y && (window.x..window.x + window.width).contains(&x) {
                    north_first.push(value);
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

/// A number of cells, which some programs write as `40.0`.
fn side(what: &'static str, text: &str) -> Result<u32, TerrainError> {
    match text.parse::<f64>() {
        Ok(side) if side.fract() == 0.0 && (1.0..=f64::from(i32::MAX)).contains(&side) => Ok(side as u32),
        _ => Err(TerrainError::Malformed {
            what,
            need: format!("1 to {}", i32::MAX),
            got: format!("{text:?}"),
        }),
    }
}

/// Why `word` is no number, if it is written in the way of other countries or programs.
fn foreign(word: &str) -> Option<TerrainError> {
    let refused = |got: &str, remedy| {
        let got = format!("{got}: {:?}", word.chars().take(24).collect::<String>());
        let need = "numbers with decimal points and spaces between them";
        Some(TerrainError::Unsupported { what: "ASCII grid", need, got, remedy })
    };
    if word.contains(';') {
        return refused("semicolons", "replace them by spaces: tr ';' ' ' < IN > OUT");
    }
    if word.contains(['d', 'D']) && word.replace(['d', 'D'], "e").parse::<f64>().is_ok() {
        return refused("exponents of Fortran", "replace D by E: tr 'Dd' 'Ee' < IN > OUT");
    }
    if word.contains('"') {
        return refused("quotes", "remove them: tr -d '\"' < IN > OUT");
    }
    let digits = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit());
    let plain = word.replace([',', '.'], "");
    if word.contains(',')
        && word.contains('.')
        && word.matches(',').count() < 3
        && digits(plain.trim_start_matches(['-', '+']))
    {
        let groups = || word.split([',', '.']).skip(1);
        let last = groups().count() - 1;
        if !word.ends_with([',', '.']) && groups().take(last).all(|group| group.len() == 3) {
            return refused(
                "separators of thousands",
                "write them without separators and with decimal points",
            );
        }
    }
    match word.split_once(',') {
        None => None,
        Some((whole, fraction)) if digits(whole.trim_start_matches(['-', '+'])) => {
            let fraction = fraction.split(['e', 'E']).next().unwrap_or_default();
            match digits(fraction) {
                true => refused("decimal commas", "replace them by points: tr ',' '.' < IN > OUT"),
                false => refused("commas between numbers", "replace them by spaces: tr ',' ' ' < IN > OUT"),
            }
        }
        Some(_) => refused("commas between numbers", "replace them by spaces: tr ',' ' ' < IN > OUT"),
    }
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
                if let Some(cause) = foreign(&String::from_utf8_lossy(&word)) {
                    return Err(cause);
                }
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
