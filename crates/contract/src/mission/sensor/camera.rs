//! The camera of a helicopter.

use serde::{Deserialize, Serialize};

use crate::mission::kind::Kind;
use crate::wire::Block;
use crate::wire::codec::RADIUS;

/// The cells whose middle is at most `radius_m` from its way: what a camera shows that looks down in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Above 0, at most [`Camera::RADIUS_MAX_M`].
    pub radius_m: f64,
}

impl Camera {
    /// Farthest that a camera sees, metres.
    pub const RADIUS_MAX_M: f64 = 1000.0;
}

impl Kind for Camera {
    const NAME: &'static str = "camera";

    fn parameters(&mut self, block: &mut Block<'_>) {
        block.float(
            "radius_m",
            "How far it sees to each side of its way, metres.",
            RADIUS,
            &mut self.radius_m,
        );
    }
}
