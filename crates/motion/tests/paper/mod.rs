//! The motion parameters of Sakamoto & Kunii 2023.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_6};

use contract::{MotionParameters, SoilMotion};

/// 90/5/5 on hard ground, 70/10/10 with 10 stuck on sand, two half hops there; Mars.
pub const PARAMETERS: MotionParameters = MotionParameters {
    hard: SoilMotion { intended: 0.9, stuck: 0.0, sideways: 0.05, flights: 1 },
    sand: SoilMotion { intended: 0.7, stuck: 0.1, sideways: 0.1, flights: 2 },
    slope_limit_rad: FRAC_PI_6,
    launch_angle_rad: FRAC_PI_4,
    gravity_mps2: 3.72,
    vertical: false,
    table: 0,
};
