//! Random numbers of one use, a pure function of its seed and label.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The seed of the planners of a stage, which are numbered from 1; that of the first is the mission's.
#[must_use]
pub fn stage_seed(seed: u64, stage: u32) -> u64 {
    seed ^ u64::from(stage - 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

/// A ChaCha8 stream. Its key is that of `motion::Draw`: the seed, little-endian, then the label in ASCII.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of `seed` for the use that `label` names.
    ///
    /// # Panics
    /// If the label has more than 24 bytes.
    #[must_use]
    pub fn new(seed: u64, label: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..8 + label.len()].copy_from_slice(label.as_bytes());
        Self(ChaCha8Rng::from_seed(key))
    }

    /// A uniform number in [0, 1) with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A uniform number in [`low`, `high`).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.uniform() * (high - low)
    }
}
