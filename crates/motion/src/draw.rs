//! Random numbers as a pure function of (seed, domain, robot, decision).
//!
//! # The definition, for other implementations
//! One decision has one ChaCha8 stream (D. J. Bernstein's layout: 256-bit key, 64-bit block counter
//! from 0, 64-bit stream number in the nonce's place).
//! - **Key**, 32 bytes: bytes 0–7 the seed, little-endian; bytes 8–31 the domain's label in ASCII,
//!   zero-padded (`motion` for [`Domain::Motion`]).
//! - **Stream number**: robot · 2^48 + decision.
//! - **Words** of 32 bits are read in order from the stream's first block only: a decision has
//!   [`Draw::WORDS_MAX`] of them.
//! - **Uniform number** in [0, 1): two words, the earlier one the low half of a 64-bit integer n;
//!   floor(n / 2^11) · 2^−53.
//!
//! So any process can repeat a draw on its own, in any order, after any number of restarts.

use contract::{Decision, RobotId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The purpose of random numbers. Each domain has its own key, so that more draws in one never shift another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Domain {
    /// The branch of a hop.
    Motion,
    /// The launch and the impacts of a hop that is followed by physics.
    Contact,
}

impl Domain {
    /// The label in the key, at most 24 ASCII characters. Changing it changes the outcomes of all
    /// recorded runs.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Domain::Motion => "motion",
            Domain::Contact => "contact",
        }
    }
}

/// The stream of one decision's random numbers.
#[derive(Clone, Debug)]
pub struct Draw {
    stream: ChaCha8Rng,
    words: usize,
}

impl Draw {
    /// Words of 32 bits that one decision may use: one ChaCha block.
    pub const WORDS_MAX: usize = 16;

    /// The stream of a decision, at its first number.
    ///
    /// # Panics
    /// If the decision does not fit into 48 bits; a run ends at [`contract::limits::DECISIONS_MAX`].
    #[must_use]
    pub fn new(seed: u64, domain: Domain, robot: RobotId, decision: Decision) -> Self {
        let (key, number) = Self::key(seed, domain, robot, decision);
        let mut stream = ChaCha8Rng::from_seed(key);
        stream.set_stream(number);
        Self { stream, words: 0 }
    }

    /// The key and the number of the stream of a decision.
    ///
    /// # Panics
    /// As [`Draw::new`].
    #[must_use]
    pub fn key(seed: u64, domain: Domain, robot: RobotId, decision: Decision) -> ([u8; 32], u64) {
        assert!(decision.0 < 1 << 48, "decision {decision} needs to fit into 48 bits");
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..8 + domain.label().len()].copy_from_slice(domain.label().as_bytes());
        (key, u64::from(robot.0) << 48 | decision.0)
    }

    /// A uniform number in [0, 1) with 53 random bits; takes two words.
    ///
    /// # Panics
    /// If the decision's words are used up.
    pub fn uniform(&mut self) -> f64 {
        self.words += 2;
        assert!(
            self.words <= Self::WORDS_MAX,
            "a decision has {} words, needs {}",
            Self::WORDS_MAX,
            self.words
        );
        (self.stream.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }
}
