//! A small writer of GeoTIFFs in every layout the reader promises to read (TIFF 6.0, BigTIFF).

use std::io::Write;

/// How a sample is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    U8,
    I16,
    U16,
    I32,
    F32,
    F64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Packing {
    None,
    Lzw,
    Deflate,
}

/// A GeoTIFF to be: change what a test is about, then [`GeoTiff::bytes`].
#[derive(Clone, Debug)]
pub struct GeoTiff {
    pub width: usize,
    pub height: usize,
    /// Northernmost row first, as TIFF has it.
    pub values: Vec<f64>,
    pub sample: Sample,
    pub packing: Packing,
    pub predictor: u16,
    /// Rows of a strip, or sides of a tile.
    pub chunk: (usize, usize),
    pub tiled: bool,
    pub big_endian: bool,
    pub big_tiff: bool,
    pub nodata: Option<&'static str>,
    pub metadata: Option<&'static str>,
    pub scale: Option<Vec<f64>>,
    pub tiepoint: Option<Vec<f64>>,
    pub transformation: Option<Vec<f64>>,
    /// (key, value) of short GeoKeys; `None` leaves the directory out.
    pub keys: Option<Vec<(u16, u16)>>,
    /// A GeoKey of text.
    pub citation: Option<(u16, &'static str)>,
    /// Tags that replace or join the others: (tag, values as LONG).
    pub extra: Vec<(u16, Vec<u32>)>,
    pub mask: Option<Mask>,
}

/// The mask of a GeoTIFF to be, in a directory behind it.
#[derive(Clone, Debug)]
pub struct Mask {
    /// Northernmost row first.
    pub counts: Vec<bool>,
    /// 1, as GDAL has it, or 8.
    pub bits: usize,
    pub packing: Packing,
    /// Rows of a strip; 0 for tiles of 16 x 16.
    pub rows: usize,
    /// Whether an overview and the mask of that come first, as in cloud-optimised files.
    pub after_overview: bool,
}

impl GeoTiff {
    /// A projected float32 model with one strip, cells of 2 m, north-western corner (1000, 5000).
    pub fn new(width: usize, height: usize, values: Vec<f64>) -> Self {
        assert_eq!(values.len(), width * height);
        Self {
            width,
            height,
            values,
            sample: Sample::F32,
            packing: Packing::None,
            predictor: 1,
            chunk: (width, height),
            tiled: false,
            big_endian: false,
            big_tiff: false,
            nodata: None,
            metadata: None,
            scale: Some(vec![2.0, 2.0, 0.0]),
            tiepoint: Some(vec![0.0, 0.0, 0.0, 1000.0, 5000.0, 0.0]),
            transformation: None,
            keys: Some(vec![(1024, 1), (1025, 1), (3072, 32633), (3076, 9001)]),
            citation: None,
            extra: Vec::new(),
            mask: None,
        }
    }

    /// A file whose cells say which cells of another count.
    pub fn of_counts(width: usize, height: usize, counts: &[bool]) -> Self {
        let values = counts.iter().map(|&counts| if counts { 255.0 } else { 0.0 }).collect();
        Self {
            sample: Sample::U8,
            keys: None,
            scale: None,
            tiepoint: None,
            ..Self::new(width, height, values)
        }
    }

    // Long: a file is written from its first byte to its last.
    pub fn bytes(&self) -> Vec<u8> {
        let chunks = self.chunks();
        let (bits, format) = match self.sample {
            Sample::U8 => (8, 1),
            Sample::U16 => (16, 1),
            Sample::I16 => (16, 2),
            Sample::I32 => (32, 2),
            Sample::F32 => (32, 3),
            Sample::F64 => (64, 3),
        };
        let mut out = Out { bytes: Vec::new(), big_endian: self.big_endian, wide: self.big_tiff };
        out.bytes.extend(if self.big_endian { b"MM" } else { b"II" });
        if self.big_tiff {
            out.number(43, 2);
            out.number(8, 2);
            out.number(0, 2);
        } else {
            out.number(42, 2);
        }
        let directory_at = out.bytes.len();
        out.offset(0);
        let mut offsets = Vec::new();
        for chunk in &chunks {
            offsets.push(out.bytes.len() as u32);
            out.bytes.extend(chunk);
        }
        let counts: Vec<u32> = chunks.iter().map(|chunk| chunk.len() as u32).collect();

        let mut tags: std::collections::BTreeMap<u16, Value> = std::collections::BTreeMap::new();
        let mut long = |tag: u16, values: Vec<u32>| tags.insert(tag, Value::Long(values));
        long(256, vec![self.width as u32]);
        long(257, vec![self.height as u32]);
        long(258, vec![bits]);
        long(259, vec![self.packing.code()]);
        long(262, vec![1]);
        long(277, vec![1]);
        long(339, vec![format]);
        if self.predictor != 1 {
            long(317, vec![u32::from(self.predictor)]);
        }
        if self.tiled {
            long(322, vec![self.chunk.0 as u32]);
            long(323, vec![self.chunk.1 as u32]);
            long(324, offsets);
            long(325, counts);
        } else {
            long(273, offsets);
            long(278, vec![self.chunk.1 as u32]);
            long(279, counts);
        }
        for (tag, values) in [(33550, &self.scale), (33922, &self.tiepoint), (34264, &self.transformation)] {
            if let Some(values) = values {
                tags.insert(tag, Value::Double(values.clone()));
            }
        }
        if let Some(keys) = &self.keys {
            let cited = self.citation.map(|(key, text)| [key, 34737, text.len() as u16, 0]);
            let header = [1, 1, 0, keys.len() as u16 + u16::from(cited.is_some())];
            let entries = keys.iter().flat_map(|&(key, value)| [key, 0, 1, value]);
            let entries = header.into_iter().chain(entries).chain(cited.into_iter().flatten());
            tags.insert(34735, Value::Short(entries.collect()));
        }
        let citation = self.citation.map(|(_, text)| text);
        for (tag, text) in [(34737, citation), (42112, self.metadata), (42113, self.nodata)] {
            if let Some(text) = text {
                tags.insert(tag, Value::Text(text));
            }
        }
        for (tag, values) in &self.extra {
            tags.insert(*tag, Value::Long(values.clone()));
        }
        let mut next_at = out.directory(directory_at, &tags);
        if let Some(mask) = &self.mask {
            if mask.after_overview {
                let half = Mask { counts: vec![false; (self.width / 2) * (self.height / 2)], ..mask.clone() };
                next_at = half.write(&mut out, next_at, (self.width / 2, self.height / 2), 1);
                next_at = half.write(&mut out, next_at, (self.width / 2, self.height / 2), 5);
            }
            mask.write(&mut out, next_at, (self.width, self.height), 4);
        }
        out.bytes
    }

    /// Bytes of the first strip or tile.
    pub fn packed_bytes(&self) -> u32 {
        self.chunks()[0].len() as u32
    }

    /// Strips or tiles in file order, packed.
    fn chunks(&self) -> Vec<Vec<u8>> {
        let (chunk_width, chunk_height) = if self.tiled { self.chunk } else { (self.width, self.chunk.1) };
        let mut chunks = Vec::new();
        for top in (0..self.height).step_by(chunk_height) {
            for left in (0..self.width).step_by(chunk_width) {
                // Tiles are padded to their full size, strips are cut at the last row.
                let rows = if self.tiled { chunk_height } else { chunk_height.min(self.height - top) };
                let mut bytes = Vec::new();
                for y in top..top + rows {
                    let row: Vec<f64> = (left..left + chunk_width)
                        .map(|x| self.values[y.min(self.height - 1) * self.width + x.min(self.width - 1)])
                        .collect();
                    bytes.extend(self.row(&row));
                }
                chunks.push(self.packing.pack(bytes));
            }
        }
        chunks
    }

    fn row(&self, values: &[f64]) -> Vec<u8> {
        // Big-endian bytes of every sample; what the predictors and the byte order then work on.
        let samples: Vec<Vec<u8>> = values
            .iter()
            .map(|&value| match self.sample {
                Sample::U8 => vec![value as u8],
                Sample::I16 => (value as i16).to_be_bytes().into(),
                Sample::U16 => (value as u16).to_be_bytes().into(),
                Sample::I32 => (value as i32).to_be_bytes().into(),
                Sample::F32 => (value as f32).to_be_bytes().into(),
                Sample::F64 => value.to_be_bytes().into(),
            })
            .collect();
        let size = samples[0].len();
        if self.predictor == 3 {
            // Floating point: byte planes, most significant first, then differences of bytes.
            let planes: Vec<u8> =
                (0..size).flat_map(|byte| samples.iter().map(move |sample| sample[byte])).collect();
            let shifted = std::iter::once(0).chain(planes.iter().copied());
            return planes.iter().zip(shifted).map(|(byte, before)| byte.wrapping_sub(before)).collect();
        }
        let whole = |sample: &Vec<u8>| sample.iter().fold(0u64, |value, byte| value << 8 | u64::from(*byte));
        let mut before = 0;
        let mut bytes = Vec::new();
        for sample in &samples {
            let value = whole(sample);
            // Horizontal differences of whole samples.
            let stored = if self.predictor == 2 { value.wrapping_sub(before) } else { value };
            before = value;
            let stored = stored.to_be_bytes();
            let stored = &stored[8 - size..];
            if self.big_endian { bytes.extend(stored) } else { bytes.extend(stored.iter().rev()) }
        }
        bytes
    }
}

impl Packing {
    fn code(self) -> u32 {
        match self {
            Packing::None => 1,
            Packing::Lzw => 5,
            Packing::Deflate => 8,
        }
    }

    fn pack(self, bytes: Vec<u8>) -> Vec<u8> {
        match self {
            Packing::None => bytes,
            Packing::Lzw => {
                weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8).encode(&bytes).unwrap()
            }
            Packing::Deflate => {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
                encoder.write_all(&bytes).unwrap();
                encoder.finish().unwrap()
            }
        }
    }
}

impl Mask {
    fn write(
        &self,
        out: &mut Out,
        pointer_at: usize,
        (width, height): (usize, usize),
        subfile: u32,
    ) -> usize {
        let tiled = self.rows == 0;
        let (columns, rows) = if tiled { (16, 16) } else { (width, self.rows) };
        let (mut offsets, mut counts) = (Vec::new(), Vec::new());
        for top in (0..height).step_by(rows) {
            for left in (0..width).step_by(columns) {
                let rows = if tiled { rows } else { rows.min(height - top) };
                let mut bytes = Vec::new();
                for y in top..top + rows {
                    let counts = |x: usize| x < width && y < height && self.counts[y * width + x];
                    let row: Vec<u8> = (left..left + columns).map(|x| u8::from(counts(x))).collect();
                    match self.bits {
                        1 => bytes.extend(row.chunks(8).map(|bits| {
                            bits.iter().enumerate().map(|(index, bit)| bit << (7 - index)).sum::<u8>()
                        })),
                        _ => bytes.extend(row.iter().map(|bit| 255 * bit)),
                    }
                }
                let packed = self.packing.pack(bytes);
                offsets.push(out.bytes.len() as u32);
                counts.push(packed.len() as u32);
                out.bytes.extend(packed);
            }
        }
        let mut tags: std::collections::BTreeMap<u16, Value> = std::collections::BTreeMap::new();
        let photometric = if subfile & 4 == 0 { 1 } else { 4 };
        for (tag, value) in [
            (254, subfile),
            (256, width as u32),
            (257, height as u32),
            (258, self.bits as u32),
            (259, self.packing.code()),
            (262, photometric),
            (277, 1),
        ] {
            tags.insert(tag, Value::Long(vec![value]));
        }
        if tiled {
            tags.insert(322, Value::Long(vec![16]));
            tags.insert(323, Value::Long(vec![16]));
            tags.insert(324, Value::Long(offsets));
            tags.insert(325, Value::Long(counts));
        } else {
            tags.insert(273, Value::Long(offsets));
            tags.insert(278, Value::Long(vec![rows as u32]));
            tags.insert(279, Value::Long(counts));
        }
        out.directory(pointer_at, &tags)
    }
}

enum Value {
    Short(Vec<u16>),
    Long(Vec<u32>),
    Double(Vec<f64>),
    Text(&'static str),
}

struct Out {
    bytes: Vec<u8>,
    big_endian: bool,
    wide: bool,
}

impl Out {
    fn number(&mut self, value: u64, size: usize) {
        let bytes = value.to_be_bytes();
        let bytes = &bytes[8 - size..];
        if self.big_endian { self.bytes.extend(bytes) } else { self.bytes.extend(bytes.iter().rev()) }
    }

    fn offset(&mut self, value: u64) {
        self.number(value, if self.wide { 8 } else { 4 });
    }

    /// Writes a directory, and where it is at `pointer_at`. Where the place of the next one goes.
    fn directory(&mut self, pointer_at: usize, tags: &std::collections::BTreeMap<u16, Value>) -> usize {
        // Values that do not fit into their entry come first, then the directory.
        let inline = if self.wide { 8 } else { 4 };
        let mut entries = Vec::new();
        for (tag, value) in tags {
            let mut own = Out { bytes: Vec::new(), big_endian: self.big_endian, wide: self.wide };
            let (kind, count) = match value {
                Value::Short(values) => {
                    values.iter().for_each(|&value| own.number(u64::from(value), 2));
                    (3, values.len())
                }
                Value::Long(values) => {
                    values.iter().for_each(|&value| own.number(u64::from(value), 4));
                    (4, values.len())
                }
                Value::Double(values) => {
                    values.iter().for_each(|&value| own.number(value.to_bits(), 8));
                    (12, values.len())
                }
                Value::Text(text) => {
                    own.bytes.extend(text.bytes().chain([0]));
                    (2, text.len() + 1)
                }
            };
            if own.bytes.len() <= inline {
                own.bytes.resize(inline, 0);
            } else {
                let at = self.bytes.len() as u64;
                self.bytes.append(&mut own.bytes);
                own.offset(at);
            }
            entries.push((*tag, kind, count as u64, own.bytes));
        }
        let at = self.bytes.len() as u64;
        self.number(entries.len() as u64, if self.wide { 8 } else { 2 });
        for (tag, kind, count, field) in entries {
            self.number(u64::from(tag), 2);
            self.number(kind, 2);
            self.offset(count);
            self.bytes.extend(field);
        }
        let next_at = self.bytes.len();
        self.offset(0);
        let mut pointer = Out { bytes: Vec::new(), big_endian: self.big_endian, wide: self.wide };
        pointer.offset(at);
        self.bytes[pointer_at..pointer_at + pointer.bytes.len()].copy_from_slice(&pointer.bytes);
        next_at
    }
}
