//! What sensors have shown of one cell, and what is believed of its speed then.

use rover::{Speed, SpeedDistribution};

use crate::Sensor;

/// What sensors have shown of the speed of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sighting {
    /// The true speed; `None` if nobody saw it.
    pub speed: Option<Speed>,
    /// What a camera that errs reads; of no account beside the true speed.
    pub reading: Option<Speed>,
}

impl Sighting {
    /// What is believed of the speed: planners, guard and displays count with it. Without a camera that errs a reading tells
    /// nothing.
    #[must_use]
    pub fn belief(self, prior: SpeedDistribution, camera: Option<&Sensor>) -> SpeedDistribution {
        match (self.speed, camera.zip(self.reading)) {
            (Some(speed), _) => SpeedDistribution::certain(speed),
            (None, Some((camera, reading))) => camera.belief(prior, reading),
            (None, None) => prior,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_true_speed_counts_before_a_reading_and_a_reading_before_the_prior() {
        let prior = SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let camera = Sensor::with_accuracy(0.8).unwrap();
        let belief =
            |speed, reading, camera: Option<&Sensor>| Sighting { speed, reading }.belief(prior, camera);
        let certain = SpeedDistribution::certain(Speed::Slow);
        assert_eq!(belief(Some(Speed::Slow), Some(Speed::Fast), Some(&camera)), certain);
        let posterior = camera.posterior(&prior, Speed::Fast).unwrap();
        assert_eq!(belief(None, Some(Speed::Fast), Some(&camera)), posterior);
        assert!(posterior.probability(Speed::Fast) > prior.probability(Speed::Fast));
        assert_eq!(belief(None, Some(Speed::Fast), None), prior, "nobody knows how well it was read");
        assert_eq!(belief(None, None, Some(&camera)), prior);
    }
}
