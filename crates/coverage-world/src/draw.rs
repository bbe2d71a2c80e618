//! Random numbers as a function of (seed, purpose), as `motion` draws those of hops.
//!
//! The generator is ChaCha8. Its key is the seed (eight bytes, little-endian) followed by the purpose's label in ASCII,
//! zero-padded to 24 bytes.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The purpose of random numbers. Each has a key of its own, so that draws for one never shift another.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// Which cells are obstacles.
    Obstacles,
    /// Where the rovers start, and which way they face.
    Starts,
}

impl Purpose {
    /// Changing a label changes all worlds or starts.
    fn label(self) -> &'static str {
        match self {
            Purpose::Obstacles => "coverage obstacles",
            Purpose::Starts => "coverage starts",
        }
    }
}

/// The numbers of one seed and purpose, in order.
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    pub(crate) fn new(seed: u64, purpose: Purpose) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..8 + purpose.label().len()].copy_from_slice(purpose.label().as_bytes());
        Self(ChaCha8Rng::from_seed(key))
    }

    /// A number from 0 to `bound` − 1, by Lemire's multiplication. Without his rejection step, the bias is below
    /// `bound` / 2⁶⁴.
    pub(crate) fn below(&mut self, bound: usize) -> usize {
        ((u128::from(self.0.next_u64()) * bound as u128) >> 64) as usize
    }
}
