//! Standard normal numbers as a pure function of (key, index).
//!
//! One ChaCha8 stream for each hop; number `index` is made of its words 4 `index` to 4 `index` + 3: two uniform numbers of 53 bits, by
//! Box and Muller, the cosine. So a number does not depend on how many were used before it.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Farthest from 0 that a number is.
pub const NORMAL_MAX: f64 = 4.0;

/// The numbers of one hop.
#[derive(Clone, Debug)]
pub struct Noise {
    /// `None`: all numbers are 0.
    stream: Option<ChaCha8Rng>,
}

impl Noise {
    /// The numbers of a stream under a key.
    #[must_use]
    pub fn new(key: [u8; 32], stream: u64) -> Self {
        let mut random = ChaCha8Rng::from_seed(key);
        random.set_stream(stream);
        Self { stream: Some(random) }
    }

    /// No noise.
    #[must_use]
    pub fn none() -> Self {
        Self { stream: None }
    }

    /// Number `index`, within ±[`NORMAL_MAX`].
    pub fn normal(&mut self, index: u64) -> f64 {
        let Some(stream) = &mut self.stream else { return 0.0 };
        let place = u128::from(index) * 4;
        if stream.get_word_pos() != place {
            stream.set_word_pos(place);
        }
        let mut uniform = || (stream.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64);
        // The logarithm of 0 is left out.
        let (radius, turn) = (1.0 - uniform(), uniform());
        let normal = libm::sqrt(-2.0 * libm::log(radius)) * libm::cos(std::f64::consts::TAU * turn);
        normal.clamp(-NORMAL_MAX, NORMAL_MAX)
    }
}
