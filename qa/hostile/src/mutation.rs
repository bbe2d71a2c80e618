//! Valid input with something done to it, the same on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// What numbers in a text become.
const NUMBERS: [&str; 18] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "1048577",
];

/// What words in binary input become.
const WORDS: [u64; 12] = [
    0,
    1,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    i64::MAX as u64,
    u64::MAX,
    f64::NAN.to_bits(),
    f64::INFINITY.to_bits(),
];

/// Mutates one input after another; the same seed makes the same.
#[derive(Debug)]
pub struct Mutator {
    generator: ChaCha8Rng,
}

impl Mutator {
    /// The mutations of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { generator: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// `input` with one to four things done to it; `other` is valid input too, of which a part may come in.
    pub fn mutate(&mut self, input: &[u8], other: &[u8]) -> Vec<u8> {
        let mut bytes = input.to_vec();
        for _ in 0..=self.below(3) {
            self.change(&mut bytes, other);
        }
        bytes
    }

    fn change(&mut self, bytes: &mut Vec<u8>, other: &[u8]) {
        if bytes.is_empty() {
            bytes.push(self.below(256) as u8);
            return;
        }
        let at = self.below(bytes.len());
        match self.below(9) {
            0 => bytes[at] ^= 1 << self.below(8),
            1 => bytes[at] = self.below(256) as u8,
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..self.end(at, bytes.len()))),
            4 => {
                let end = self.end(at, bytes.len());
                bytes.extend_from_within(at..end);
                bytes[at..].rotate_right(end - at);
            }
            5 if !other.is_empty() => {
                let from = self.below(other.len());
                let part = &other[from..self.end(from, other.len())];
                bytes.splice(at..at, part.iter().copied());
            }
            6 => self.number(bytes, at),
            _ => self.word(bytes, at),
        }
    }

    /// Puts an extreme word of one to eight bytes at its place, which is a multiple of its size.
    fn word(&mut self, bytes: &mut [u8], at: usize) {
        let size = 1 << self.below(4);
        let word = WORDS[self.below(WORDS.len())];
        let word = if self.below(2) == 0 { word.to_le_bytes() } else { word.to_be_bytes() };
        let at = at / size * size;
        let (Some(place), from) = (bytes.get_mut(at..at + size), if word[0] == 0 { 8 - size } else { 0 })
        else {
            return;
        };
        place.copy_from_slice(&word[from..from + size]);
    }

    /// Replaces the next number of a text from `at` on.
    fn number(&mut self, bytes: &mut Vec<u8>, at: usize) {
        let part_of_number = |byte: &u8| byte.is_ascii_digit() || b".-+".contains(byte);
        let Some(start) = bytes[at..].iter().position(|byte| byte.is_ascii_digit()).map(|skip| at + skip)
        else {
            return;
        };
        let length =
            bytes[start..].iter().position(|byte| !part_of_number(byte)).unwrap_or(bytes.len() - start);
        let number = NUMBERS[self.below(NUMBERS.len())];
        bytes.splice(start..start + length, number.bytes());
    }

    /// Where a part that begins at `start` ends: mostly soon.
    fn end(&mut self, start: usize, length: usize) -> usize {
        let most = (length - start).min(if self.below(4) == 0 { usize::MAX } else { 16 });
        start + 1 + self.below(most)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.generator.next_u64() % bound.max(1) as u64) as usize
    }
}
