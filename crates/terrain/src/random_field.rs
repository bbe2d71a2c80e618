//! Random terrain from a seed: a sum of Gaussian hills and hollows.

use contract::Range;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::Gaussian;

/// A sum of random Gaussians; the same seed gives the same ground, bit for bit, on every machine.
///
/// The generator is ChaCha8, its key the seed (eight bytes, little-endian) followed by the 24 bytes
/// of [`RandomField::DOMAIN`]. Each hill takes five draws in this order: x and y of the centre (even
/// over the map with a margin of the largest σ around it), σ, amplitude (even over their ranges), and
/// a coin (below one half: a hollow, with the sign of the amplitude turned). A draw is the top 53
/// bits of one 64-bit word over 2⁵³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomField {
    /// Seed of the generator.
    pub seed: u64,
    /// Number of hills and hollows together.
    pub hills: u32,
    /// Range of σ, metres, above 0.
    pub sigma_m: Range,
    /// Range of the amplitude, metres.
    pub amplitude_m: Range,
}

impl RandomField {
    /// Bytes that follow the seed in the generator's key.
    pub const DOMAIN: &[u8; 24] = b"hopper random field v1  ";

    /// The hills over a map of `extent_m` (width, height), metres.
    #[must_use]
    pub fn gaussians(&self, extent_m: [f64; 2]) -> Vec<Gaussian> {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..].copy_from_slice(Self::DOMAIN);
        let mut generator = ChaCha8Rng::from_seed(key);
        let mut uniform = || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let margin = self.sigma_m.max;
        (0..self.hills)
            .map(|_| {
                let centre_m = extent_m.map(|extent| -margin + uniform() * (extent + 2.0 * margin));
                let sigma_m = within(self.sigma_m, uniform());
                let amplitude_m = within(self.amplitude_m, uniform());
                let sign = if uniform() < 0.5 { -1.0 } else { 1.0 };
                Gaussian { centre_m, sigma_m, amplitude_m: sign * amplitude_m }
            })
            .collect()
    }
}

fn within(range: Range, share: f64) -> f64 {
    range.min + share * (range.max - range.min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIELD: RandomField = RandomField {
        seed: 7,
        hills: 40,
        sigma_m: Range { min: 1.0, max: 3.0 },
        amplitude_m: Range { min: 0.1, max: 0.4 },
    };

    #[test]
    fn the_same_seed_gives_the_same_hills_and_another_gives_others() {
        let hills = FIELD.gaussians([20.0, 10.0]);
        assert_eq!(hills, FIELD.gaussians([20.0, 10.0]));
        assert_ne!(hills, RandomField { seed: 8, ..FIELD }.gaussians([20.0, 10.0]));
        let more = RandomField { hills: 41, ..FIELD }.gaussians([20.0, 10.0]);
        assert_eq!(more[..40], hills[..], "another hill leaves the first ones alone");
    }

    #[test]
    fn hills_keep_to_their_ranges_and_come_in_both_signs() {
        let hills = FIELD.gaussians([20.0, 10.0]);
        for hill in &hills {
            assert!((1.0..=3.0).contains(&hill.sigma_m));
            assert!((0.1..=0.4).contains(&hill.amplitude_m.abs()));
            assert!((-3.0..=23.0).contains(&hill.centre_m[0]) && (-3.0..=13.0).contains(&hill.centre_m[1]));
        }
        assert!(hills.iter().any(|hill| hill.amplitude_m > 0.0));
        assert!(hills.iter().any(|hill| hill.amplitude_m < 0.0));
    }

    /// Golden bits: a change of generator, key or draw order changes every mission on such ground.
    #[test]
    fn the_first_hill_of_seed_seven_stays_what_it_is() {
        let hill = FIELD.gaussians([20.0, 10.0])[0];
        let bits = [hill.centre_m[0], hill.centre_m[1], hill.sigma_m, hill.amplitude_m].map(f64::to_bits);
        assert_eq!(bits, GOLDEN, "{hill:?} {bits:#x?}");
    }
    const GOLDEN: [u64; 4] =
        [0x4029_cbeb_8cd4_9fa2, 0x4026_08af_4376_7e84, 0x3ffc_fdd5_0227_4ec0, 0x3fca_847c_22a1_de70];
}
