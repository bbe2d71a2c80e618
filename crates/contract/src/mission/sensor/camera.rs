//! The camera of a helicopter.

use serde::{Deserialize, Serialize};

use super::SensorKind;
use crate::block::Block;
use crate::codec::RADIUS;
use crate::mission::kind::Kind;

/// The cells whose middle is at most `radius_m` from its way: what a camera shows that looks down in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Above 0, at most [`Camera::RADIUS_MAX_M`].
    pub radius_m: f64,
}

impl Camera {
    /// Farthest that a camera sees, metres.
    pub const RADIUS_MAX_M: f64 = crate::limits::CAMERA_RADIUS_MAX_M;
}

impl Kind for Camera {
    const NAME: &'static str = "camera";

    fn parameters(&mut self, block: &mut Block<'_>) {
        radius(block, &mut self.radius_m);
    }
}

/// The parameter `radius_m` of any camera.
pub(super) fn radius(block: &mut Block<'_>, radius_m: &mut f64) {
    block.float("radius_m", "How far it sees to each side of its way, metres.", RADIUS, radius_m);
}

impl SensorKind for Camera {
    fn in_words(&self) -> String {
        format!("{:.1} m to each side", self.radius_m)
    }

    fn view_m(&self) -> Option<f64> {
        Some(self.radius_m)
    }
}
