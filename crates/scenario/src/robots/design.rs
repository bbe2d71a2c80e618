//! How a hopper hops and sees.

use contract::{MotionParameters, SensorParameters};

/// How a hopper hops and sees.
#[derive(Clone, Copy)]
pub(crate) struct Design {
    pub motion: MotionParameters,
    pub sensor: SensorParameters,
}
