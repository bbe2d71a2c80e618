//! A camera whose readings of the ground's speed may be wrong.

use serde::{Deserialize, Serialize};

use super::SensorKind;
use super::camera::radius;
use crate::block::Block;
use crate::codec::PROBABILITY;
use crate::mission::kind::Kind;

/// As [`super::Camera`], but what it reads of a cell's speed may be wrong: partial observation (Folsom et al. 2021, eqs 13 to
/// 16).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErringCamera {
    /// Above 0, at most [`super::Camera::RADIUS_MAX_M`].
    pub radius_m: f64,
    /// Probability that it reads the true speed, 0 to 1; the other three are equally likely.
    pub accuracy: f64,
}

impl Kind for ErringCamera {
    const NAME: &'static str = "erring_camera";

    fn parameters(&mut self, block: &mut Block<'_>) {
        radius(block, &mut self.radius_m);
        block.float("accuracy", "Probability that it reads the true speed.", PROBABILITY, &mut self.accuracy);
    }
}

impl SensorKind for ErringCamera {
    fn in_words(&self) -> String {
        format!("{:.1} m to each side, {:.1} % of the speeds right", self.radius_m, 100.0 * self.accuracy)
    }

    fn view_m(&self) -> Option<f64> {
        Some(self.radius_m)
    }

    fn accuracy(&self) -> Option<f64> {
        Some(self.accuracy)
    }
}
