//! Decodes a strip or tile of a TIFF: decompression (TIFF 6.0, sections 9 and 13), predictors (section 14;
//! Adobe Photoshop TIFF Technical Note 3), samples.

use std::io::Read;

use crate::TerrainError;
use crate::tiff_directory::Order;

/// Number type of the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sample {
    /// One bit, as masks have; rows begin at whole bytes.
    Bit,
    U8,
    U16,
    U32,
    I8,
    I16,
    I32,
    F32,
    F64,
}

/// Compression of a strip or tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packing {
    None,
    Lzw,
    Deflate,
    PackBits,
}

/// What was subtracted from each value of a row before compression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Predictor {
    None,
    /// The sample to the left.
    Horizontal,
    /// The byte to the left, after the bytes of the row were grouped by significance.
    FloatingPoint,
}

impl Sample {
    /// The type of a SampleFormat with its BitsPerSample.
    pub fn of_codes(format: u64, bits: u64) -> Option<Self> {
        Some(match (format, bits) {
            (1, 1) => Sample::Bit,
            (1, 8) => Sample::U8,
            (1, 16) => Sample::U16,
            (1, 32) => Sample::U32,
            (2, 8) => Sample::I8,
            (2, 16) => Sample::I16,
            (2, 32) => Sample::I32,
            (3, 32) => Sample::F32,
            (3, 64) => Sample::F64,
            _ => return None,
        })
    }

    pub fn name(self) -> &'static str {
        match self {
            Sample::Bit => "bit",
            Sample::U8 => "uint8",
            Sample::U16 => "uint16",
            Sample::U32 => "uint32",
            Sample::I8 => "int8",
            Sample::I16 => "int16",
            Sample::I32 => "int32",
            Sample::F32 => "float32",
            Sample::F64 => "float64",
        }
    }

    /// Bits of a sample.
    pub fn bits(self) -> usize {
        match self {
            Sample::Bit => 1,
            Sample::U8 | Sample::I8 => 8,
            Sample::U16 | Sample::I16 => 16,
            Sample::U32 | Sample::I32 | Sample::F32 => 32,
            Sample::F64 => 64,
        }
    }

    /// Bytes of a row of so many samples.
    pub fn row_bytes(self, columns: usize) -> usize {
        (columns * self.bits()).div_ceil(8)
    }

    fn number(self, bits: u64) -> f64 {
        match self {
            Sample::Bit | Sample::U8 | Sample::U16 | Sample::U32 => f64::from(bits as u32),
            Sample::I8 => f64::from(bits as i8),
            Sample::I16 => f64::from(bits as i16),
            Sample::I32 => f64::from(bits as i32),
            Sample::F32 => f64::from(f32::from_bits(bits as u32)),
            Sample::F64 => f64::from_bits(bits),
        }
    }
}

impl Packing {
    pub fn of_code(code: u64) -> Option<Self> {
        Some(match code {
            1 => Packing::None,
            5 => Packing::Lzw,
            8 | 32946 => Packing::Deflate,
            32773 => Packing::PackBits,
            _ => return None,
        })
    }
}

impl Predictor {
    pub fn of_code(code: u64, packing: Packing, sample: Sample) -> Option<Self> {
        let packed = matches!(packing, Packing::Lzw | Packing::Deflate);
        match code {
            1 => Some(Predictor::None),
            2 if packed && sample != Sample::Bit => Some(Predictor::Horizontal),
            3 if packed && matches!(sample, Sample::F32 | Sample::F64) => Some(Predictor::FloatingPoint),
            _ => None,
        }
    }

    /// Gives `take` the numbers of one `row`, from west to east; after single bits those that fill its last byte, too.
    pub fn undo(self, row: &mut [u8], sample: Sample, order: Order, mut take: impl FnMut(f64)) {
        if sample == Sample::Bit {
            let bits = row.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1));
            return bits.for_each(|bit| take(f64::from(bit)));
        }
        let size = sample.bits() / 8;
        match self {
            Predictor::None => {
                row.chunks_exact(size).for_each(|bytes| take(sample.number(order.unsigned(bytes))));
            }
            Predictor::Horizontal => {
                // Sums wrap at the width of the sample, which keeps no more of the bits than that.
                let mask = u64::MAX >> (64 - 8 * size);
                let mut sum = 0u64;
                for bytes in row.chunks_exact(size) {
                    sum = sum.wrapping_add(order.unsigned(bytes)) & mask;
                    take(sample.number(sum));
                }
            }
            Predictor::FloatingPoint => {
                for index in 1..row.len() {
                    row[index] = row[index].wrapping_add(row[index - 1]);
                }
                let samples = row.len() / size;
                for index in 0..samples {
                    let bits =
                        (0..size).fold(0, |bits, plane| bits << 8 | u64::from(row[plane * samples + index]));
                    take(sample.number(bits));
                }
            }
        }
    }
}

/// The first `length` bytes of what `packed` holds; whatever follows them does not matter, as it does
/// not to libtiff.
pub(crate) fn unpack(packed: &[u8], packing: Packing, length: usize) -> Result<Vec<u8>, TerrainError> {
    let mut bytes = vec![0; length];
    let filled = match packing {
        Packing::None => {
            let filled = length.min(packed.len());
            bytes[..filled].copy_from_slice(&packed[..filled]);
            filled
        }
        Packing::Lzw => unpack_lzw(packed, &mut bytes)?,
        Packing::Deflate => {
            let mut decoder = flate2::read::ZlibDecoder::new(packed);
            let mut filled = 0;
            while filled < length {
                match decoder.read(&mut bytes[filled..]).map_err(|error| undecodable(&error))? {
                    0 => break,
                    more => filled += more,
                }
            }
            filled
        }
        Packing::PackBits => unpack_bits(packed, &mut bytes),
    };
    if filled < length {
        return Err(TerrainError::Truncated { need: format!("{length} bytes in a strip or tile") });
    }
    Ok(bytes)
}

fn unpack_lzw(mut packed: &[u8], bytes: &mut [u8]) -> Result<usize, TerrainError> {
    let mut decoder = weezl::decode::Configuration::with_tiff_size_switch(weezl::BitOrder::Msb, 8)
        .with_yield_on_full_buffer(true)
        .build();
    let mut filled = 0;
    while filled < bytes.len() {
        let step = decoder.decode_bytes(packed, &mut bytes[filled..]);
        packed = &packed[step.consumed_in..];
        filled += step.consumed_out;
        let status = step.status.map_err(|error| undecodable(&error))?;
        if matches!(status, weezl::LzwStatus::Done) || step.consumed_in == 0 && step.consumed_out == 0 {
            break;
        }
    }
    Ok(filled)
}

/// A count n below 128 is followed by n + 1 bytes, one above it by a byte to repeat 257 − n times.
fn unpack_bits(packed: &[u8], bytes: &mut [u8]) -> usize {
    let (mut from, mut filled) = (0, 0);
    while let (Some(&count), true) = (packed.get(from), filled < bytes.len()) {
        let count = usize::from(count);
        from += 1;
        if count < 128 {
            let length = (count + 1).min(packed.len() - from).min(bytes.len() - filled);
            bytes[filled..filled + length].copy_from_slice(&packed[from..from + length]);
            (from, filled) = (from + count + 1, filled + length);
        } else if let (Some(&byte), true) = (packed.get(from), count > 128) {
            let length = (257 - count).min(bytes.len() - filled);
            bytes[filled..filled + length].fill(byte);
            (from, filled) = (from + 1, filled + length);
        }
    }
    filled
}

fn undecodable(error: &dyn std::error::Error) -> TerrainError {
    TerrainError::Malformed {
        what: "image data",
        need: "strips or tiles that can be unpacked".into(),
        got: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of TIFF 6.0, section 9.
    #[test]
    fn pack_bits_unpacks_the_published_example() {
        let packed =
            [0xFE, 0xAA, 0x02, 0x80, 0x00, 0x2A, 0xFD, 0xAA, 0x03, 0x80, 0x00, 0x2A, 0x22, 0xF7, 0xAA];
        let expected = [
            0xAA, 0xAA, 0xAA, 0x80, 0x00, 0x2A, 0xAA, 0xAA, 0xAA, 0xAA, 0x80, 0x00, 0x2A, 0x22, 0xAA, 0xAA,
            0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA,
        ];
        assert_eq!(unpack(&packed, Packing::PackBits, 24).unwrap(), expected);
        assert!(unpack(&packed, Packing::PackBits, 25).is_err());
        assert!(unpack(&packed[..14], Packing::PackBits, 24).is_err());
    }

    #[test]
    fn lzw_without_an_end_code_is_read_as_libtiff_does() {
        let data: Vec<u8> = (0..100).collect();
        let mut encoder = weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8);
        let packed = encoder.encode(&data).unwrap();
        // The last code of nine bits, the end, begins in the byte before the last.
        assert_eq!(unpack(&packed[..packed.len() - 1], Packing::Lzw, 100).unwrap(), data);
        assert!(unpack(&packed[..packed.len() - 10], Packing::Lzw, 100).is_err());
    }
}
