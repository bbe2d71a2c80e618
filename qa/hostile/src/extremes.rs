//! Every field of a message at every extreme, one at a time, without naming a field.
//!
//! A wire type has no padding, and each of its fields lies at a multiple of its size; so every field of 4 or
//! 8 bytes is one of the words below, whatever the type, and a field that is added later is among them too.

use contract::wire::Wire;

/// Extremes of a word of four bytes: numbers, tags, halves of bytes.
const SMALL: [u32; 7] = [0, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0x0001_0000, 99];

/// Extremes of a word of eight bytes: integers, then floating-point numbers.
const LARGE: [u64; 15] = [
    0,
    1,
    i64::MAX as u64,
    i64::MIN as u64,
    u64::MAX,
    1 << 32,
    (1 << 32) + 1,
    f64::NAN.to_bits(),
    f64::INFINITY.to_bits(),
    f64::NEG_INFINITY.to_bits(),
    f64::MAX.to_bits(),
    f64::MIN.to_bits(),
    f64::MIN_POSITIVE.to_bits(),
    1.0e6_f64.to_bits(),
    (-1.0e6_f64).to_bits(),
];

/// `valid` with each of its words at each extreme, and with all its words at each at once.
#[must_use]
pub fn of<W: Wire>(valid: &W) -> Vec<W> {
    let bytes = size_of::<W>();
    let with = |at: usize, word: &[u8]| {
        let mut wire = *valid;
        bytemuck::bytes_of_mut(&mut wire)[at..at + word.len()].copy_from_slice(word);
        wire
    };
    let mut all = Vec::new();
    for at in (0..bytes).step_by(4) {
        all.extend(SMALL.iter().map(|word| with(at, &word.to_le_bytes())));
    }
    for at in (0..bytes / 8).map(|word| 8 * word) {
        all.extend(LARGE.iter().map(|word| with(at, &word.to_le_bytes())));
    }
    for word in LARGE {
        let whole = word.to_le_bytes().repeat(bytes.div_ceil(8));
        all.push(with(0, &whole[..bytes]));
    }
    all.retain(|wire| bytemuck::bytes_of(wire) != bytemuck::bytes_of(valid));
    all.dedup_by(|one, other| bytemuck::bytes_of(one) == bytemuck::bytes_of(other));
    all
}
