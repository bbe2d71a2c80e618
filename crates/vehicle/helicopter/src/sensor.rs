//! A sensor that errs: the observation multiplies the prior, and the printed equations 13 to 16 beside it.

use rover::{Speed, SpeedDistribution};

/// How likely each reading is on ground of each true speed. The readings are the four speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// First the true speed, then the reading, both in the order of [`Speed::ALL`].
    likelihoods: [SpeedDistribution; 4],
}

/// Why a sensor cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    /// Not a probability of being right.
    #[error("a sensor is right with a probability of 0 to 1, got {got}")]
    Accuracy {
        /// The number given.
        got: f64,
    },
    /// The prior excludes what the sensor says.
    #[error("a reading of {} m/Sol is impossible under the prior: the sensor or the prior is wrong", reading.m_per_sol())]
    Impossible {
        /// The reading.
        reading: Speed,
    },
}

impl Sensor {
    /// A sensor with these likelihoods: for each true speed, the distribution of its readings.
    #[must_use]
    pub fn new(likelihoods: [SpeedDistribution; 4]) -> Self {
        Self { likelihoods }
    }

    /// A sensor that reads the true speed with probability `accuracy`, and each other one equally often.
    ///
    /// # Errors
    /// If `accuracy` is no probability.
    pub fn with_accuracy(accuracy: f64) -> Result<Self, SensorError> {
        let likelihoods = Speed::ALL.map(|truth| {
            let mut readings = [(1.0 - accuracy) / 3.0; 4];
            readings[truth as usize] = accuracy;
            SpeedDistribution::new(readings)
        });
        match likelihoods {
            [Ok(a), Ok(b), Ok(c), Ok(d)] => Ok(Self::new([a, b, c, d])),
            _ => Err(SensorError::Accuracy { got: accuracy }),
        }
    }

    /// The reading on ground of speed `truth` for a uniform number in \[0, 1).
    #[must_use]
    pub fn reading(&self, truth: Speed, uniform: f64) -> Speed {
        self.likelihoods[truth as usize].quantile(uniform)
    }

    /// What is known of a cell after a reading, by Bayes' rule. P(v = 0) stays defined, unlike with means and variances.
    ///
    /// # Errors
    /// If prior and sensor together exclude the reading.
    pub fn posterior(
        &self,
        prior: &SpeedDistribution,
        reading: Speed,
    ) -> Result<SpeedDistribution, SensorError> {
        let joint = Speed::ALL
            .map(|truth| prior.probability(truth) * self.likelihoods[truth as usize].probability(reading));
        let sum: f64 = joint.iter().sum();
        SpeedDistribution::new(joint.map(|weight| weight / sum))
            .map_err(|_| SensorError::Impossible { reading })
    }

    /// What is believed of a cell after a reading: the posterior, or the prior where that excludes the reading.
    #[must_use]
    pub fn belief(&self, prior: SpeedDistribution, reading: Speed) -> SpeedDistribution {
        self.posterior(&prior, reading).unwrap_or(prior)
    }
}

/// Mean and variance of a cell's speed, in m/Sol and its square: equations 13 and 14.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// µ.
    pub mean: f64,
    /// σ².
    pub variance: f64,
}

/// Equations 15 and 16 as printed. The mean is the Bayesian one; the variance is twice the Bayesian one, and above the
/// satellite's where the helicopter sees worse. So [`Sensor`] does not use them.
#[must_use]
pub fn combined_as_printed(satellite: Estimate, helicopter: Estimate) -> Estimate {
    let beta = satellite.variance / (satellite.variance + helicopter.variance);
    Estimate {
        mean: (1.0 - beta) * satellite.mean + beta * helicopter.mean,
        variance: (1.0 - beta) * satellite.variance + beta * helicopter.variance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// P-PRINTED-SENSOR: The published equations of partial observation are tested as printed; the
    /// sensor uses Bayes' rule.
    #[test]
    fn the_printed_equations_give_twice_the_bayesian_variance() {
        let (satellite, helicopter) =
            (Estimate { mean: 100.0, variance: 900.0 }, Estimate { mean: 160.0, variance: 100.0 });
        let combined = combined_as_printed(satellite, helicopter);
        // β = 0.9.
        assert!((combined.mean - (0.1 * 100.0 + 0.9 * 160.0)).abs() < 1e-9);
        assert!((combined.variance - (0.1 * 900.0 + 0.9 * 100.0)).abs() < 1e-9);
        let bayesian = 1.0 / (1.0 / 900.0 + 1.0 / 100.0);
        assert!((combined.variance - 2.0 * bayesian).abs() < 1e-9);
    }

    #[test]
    fn the_printed_variance_is_above_the_prior_if_the_helicopter_sees_worse() {
        let satellite = Estimate { mean: 100.0, variance: 400.0 };
        let combined = combined_as_printed(satellite, Estimate { mean: 100.0, variance: 900.0 });
        assert!(combined.variance > satellite.variance);
    }

    #[test]
    fn a_perfect_sensor_makes_the_cell_certain_and_refuses_the_impossible() {
        let sensor = Sensor::with_accuracy(1.0).unwrap();
        let prior = SpeedDistribution::new([0.4, 0.0, 0.0, 0.6]).unwrap();
        for reading in [Speed::Zero, Speed::Fast] {
            assert_eq!(sensor.posterior(&prior, reading), Ok(SpeedDistribution::certain(reading)));
        }
        let error = sensor.posterior(&prior, Speed::Slow).unwrap_err();
        assert_eq!(error, SensorError::Impossible { reading: Speed::Slow });
        assert_eq!(Sensor::with_accuracy(1.5), Err(SensorError::Accuracy { got: 1.5 }));
    }

    proptest! {
        /// P-PRINTED-SENSOR.
        ///
        /// Over all readings, the posteriors average to the prior.
        #[test]
        fn posteriors_average_to_the_prior(weights in prop::array::uniform4(0.01..1.0_f64), accuracy in 0.3..0.95_f64) {
            let sum: f64 = weights.iter().sum();
            let prior = SpeedDistribution::new(weights.map(|weight| weight / sum)).unwrap();
            let sensor = Sensor::with_accuracy(accuracy).unwrap();
            let mut average = [0.0; 4];
            for reading in Speed::ALL {
                let chance: f64 = Speed::ALL
                    .iter()
                    .map(|truth| prior.probability(*truth) * sensor.likelihoods[*truth as usize].probability(reading))
                    .sum();
                let posterior = sensor.posterior(&prior, reading).unwrap();
                for (sum, probability) in average.iter_mut().zip(posterior.probabilities()) {
                    *sum += chance * probability;
                }
            }
            for (average, prior) in average.iter().zip(prior.probabilities()) {
                prop_assert!((average - prior).abs() < 1e-12);
            }
        }

        /// Independent readings may come in any order.
        #[test]
        fn readings_commute(accuracy in 0.3..0.95_f64, first in 0..4_usize, second in 0..4_usize) {
            let prior = SpeedDistribution::new([0.1, 0.2, 0.3, 0.4]).unwrap();
            let sensor = Sensor::with_accuracy(accuracy).unwrap();
            let (a, b) = (Speed::ALL[first], Speed::ALL[second]);
            let ab = sensor.posterior(&sensor.posterior(&prior, a).unwrap(), b).unwrap();
            let ba = sensor.posterior(&sensor.posterior(&prior, b).unwrap(), a).unwrap();
            for (left, right) in ab.probabilities().iter().zip(ba.probabilities()) {
                prop_assert!((left - right).abs() < 1e-12);
            }
        }
    }
}
