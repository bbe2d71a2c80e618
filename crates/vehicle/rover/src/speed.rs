//! The four speeds of the rover, and how likely each is.

/// How fast the rover gets on in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Speed {
    /// 0 m/Sol: a rover that enters is stuck.
    Zero,
    /// 50 m/Sol.
    Slow,
    /// 150 m/Sol.
    Medium,
    /// 200 m/Sol.
    Fast,
}

impl Speed {
    /// All speeds, rising.
    pub const ALL: [Self; 4] = [Self::Zero, Self::Slow, Self::Medium, Self::Fast];

    /// The speed as a number.
    #[must_use]
    pub const fn m_per_sol(self) -> f64 {
        [0.0, 50.0, 150.0, 200.0][self as usize]
    }

    /// Time for a metre; infinite at speed 0.
    #[must_use]
    pub const fn pace_sol_per_m(self) -> f64 {
        1.0 / self.m_per_sol()
    }
}

/// A probability for each of the four speeds; they sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedDistribution([f64; 4]);

/// Why four numbers are no distribution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpeedError {
    /// A number below 0, above 1, or none.
    #[error("a probability needs 0 to 1, got {got} for {} m/Sol", speed.m_per_sol())]
    Probability {
        /// The speed it was given for.
        speed: Speed,
        /// The number given.
        got: f64,
    },
    /// They do not add up.
    #[error("the probabilities of the four speeds need to sum to 1, got {got}")]
    Sum {
        /// Their sum.
        got: f64,
    },
}

impl SpeedDistribution {
    /// How far the sum may be from 1; what is within is divided by the sum.
    pub const SUM_TOLERANCE: f64 = 1e-6;

    /// The distribution with these probabilities, in the order of [`Speed::ALL`].
    ///
    /// # Errors
    /// If a number is no probability, or they do not sum to 1.
    pub fn new(probabilities: [f64; 4]) -> Result<Self, SpeedError> {
        for (speed, got) in Speed::ALL.into_iter().zip(probabilities) {
            if !(0.0..=1.0).contains(&got) {
                return Err(SpeedError::Probability { speed, got });
            }
        }
        let sum: f64 = probabilities.iter().sum();
        if (sum - 1.0).abs() > Self::SUM_TOLERANCE {
            return Err(SpeedError::Sum { got: sum });
        }
        Ok(Self(probabilities.map(|probability| probability / sum)))
    }

    /// The distribution with exactly these probabilities, which come from one that was normalised: dividing again might
    /// change their last bits.
    ///
    /// # Errors
    /// As [`SpeedDistribution::new`].
    pub fn as_given(probabilities: [f64; 4]) -> Result<Self, SpeedError> {
        Self::new(probabilities).map(|_| Self(probabilities))
    }

    /// The distribution of a cell whose speed is known.
    #[must_use]
    pub fn certain(speed: Speed) -> Self {
        let mut probabilities = [0.0; 4];
        probabilities[speed as usize] = 1.0;
        Self(probabilities)
    }

    /// The four probabilities in the order of [`Speed::ALL`].
    #[must_use]
    pub fn probabilities(&self) -> [f64; 4] {
        self.0
    }

    /// The probability of one speed.
    #[must_use]
    pub fn probability(&self, speed: Speed) -> f64 {
        self.0[speed as usize]
    }

    /// E\[v\].
    #[must_use]
    pub fn mean_m_per_sol(&self) -> f64 {
        Speed::ALL.into_iter().map(|speed| self.probability(speed) * speed.m_per_sol()).sum()
    }

    /// Standard deviation of v, the paper's measure of uncertainty.
    #[must_use]
    pub fn sd_m_per_sol(&self) -> f64 {
        let mean = self.mean_m_per_sol();
        let spread = |speed: Speed| self.probability(speed) * (speed.m_per_sol() - mean).powi(2);
        Speed::ALL.into_iter().map(spread).sum::<f64>().sqrt()
    }

    /// 1 / E\[v\], the pace that the paper's planners count with; infinite where the speed is surely 0.
    #[must_use]
    pub fn expected_pace_sol_per_m(&self) -> f64 {
        1.0 / self.mean_m_per_sol()
    }

    /// The speed below which lies the share `uniform` (0 to 1) of the distribution: a draw, if `uniform` is one.
    #[must_use]
    pub fn quantile(&self, uniform: f64) -> Speed {
        let mut sum = 0.0;
        for speed in Speed::ALL {
            sum += self.probability(speed);
            if uniform < sum {
                return speed;
            }
        }
        // A sum just below 1: the fastest speed that is possible.
        let possible = |speed: &Speed| self.probability(*speed) > 0.0;
        Speed::ALL.into_iter().rev().find(possible).unwrap_or(Speed::Zero)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_spread_are_those_of_the_definition() {
        let even = SpeedDistribution::new([0.25, 0.0, 0.0, 0.75]).unwrap();
        assert_eq!(even.mean_m_per_sol(), 150.0);
        assert!((even.sd_m_per_sol() - 7500_f64.sqrt()).abs() < 1e-12);
        assert_eq!(SpeedDistribution::certain(Speed::Slow).expected_pace_sol_per_m(), 0.02);
        assert_eq!(SpeedDistribution::certain(Speed::Zero).expected_pace_sol_per_m(), f64::INFINITY);
    }

    #[test]
    fn numbers_that_do_not_add_up_are_refused() {
        let sum = SpeedDistribution::new([0.5, 0.5, 0.5, 0.0]).unwrap_err();
        assert_eq!(sum.to_string(), "the probabilities of the four speeds need to sum to 1, got 1.5");
        let nan = SpeedDistribution::new([f64::NAN, 1.0, 0.0, 0.0]).unwrap_err();
        assert_eq!(nan.to_string(), "a probability needs 0 to 1, got NaN for 0 m/Sol");
    }

    #[test]
    fn quantiles_skip_impossible_speeds() {
        let risky = SpeedDistribution::new([0.4, 0.0, 0.0, 0.6]).unwrap();
        assert_eq!(risky.quantile(0.39), Speed::Zero);
        assert_eq!(risky.quantile(0.4), Speed::Fast);
        assert_eq!(risky.quantile(1.0), Speed::Fast);
    }
}
