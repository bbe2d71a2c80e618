//! Standard normal numbers as a pure function of (key, index).
//!
//! One ChaCha8 stream for each hop; number `index` is made of its words 4 `index` to 4 `index` + 3: two uniform numbers of 53 bits, by
//! Box and Muller, the cosine. So a number does not depend on how many were used before it.

use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Farthest from 0 that a number is.
pub const NORMAL_MAX: f64 = 4.0;

/// The numbers of one hop.
#[derive(Clone, Debug)]
pub struct Noise {
    /// `None`: all numbers are 0.
    stream: Option<ChaCha8Rng>,
    /// Which number the stream is at.
    next: u64,
}

impl Noise {
    /// The numbers of a stream under a key.
    #[must_use]
    pub fn new(key: [u8; 32], stream: u64) -> Self {
        let mut random = ChaCha8Rng::from_seed(key);
        random.set_stream(stream);
        Self { stream: Some(random), next: 0 }
    }

    /// No noise.
    #[must_use]
    pub fn none() -> Self {
        Self { stream: None, next: 0 }
    }

    /// Number `index`, within ±[`NORMAL_MAX`].
    pub fn normal(&mut self, index: u64) -> f64 {
        let Some(stream) = &mut self.stream else { return 0.0 };
        if self.next != index {
            stream.set_word_pos(u128::from(index) * 4);
        }
        self.next = index + 1;
        let mut uniform = || (stream.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64);
        // The logarithm of 0 is left out.
        let (radius, turn) = (1.0 - uniform(), uniform());
        let normal = libm::sqrt(-2.0 * libm::log(radius)) * libm::cos(std::f64::consts::TAU * turn);
        normal.clamp(-NORMAL_MAX, NORMAL_MAX)
    }

    /// By how much impact `impact`, the first being 0, has its normal lean: numbers 3 + 2 `impact` and the next, east and north,
    /// in units of `roughness`.
    #[inline]
    pub(crate) fn lean(&mut self, impact: u32, roughness: f64) -> Vector3<f64> {
        if roughness == 0.0 || self.stream.is_none() {
            return Vector3::zeros();
        }
        let first = 3 + 2 * u64::from(impact);
        Vector3::new(self.normal(first), self.normal(first + 1), 0.0) * roughness
    }
}
