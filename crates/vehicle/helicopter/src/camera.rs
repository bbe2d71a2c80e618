//! The cone in which the helicopter sees.

/// A camera that looks straight down. On slopes the ground seen is still counted as the disc that level ground would show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Height above the ground.
    pub altitude_m: f64,
    /// Angle between the axis of the cone and its side, 0 to 90 degrees.
    pub half_angle_deg: f64,
}

impl Default for Camera {
    /// 50 m up, as in the paper; 26.6 degrees, so that a disc of 25 m radius is seen.
    fn default() -> Self {
        Self { altitude_m: 50.0, half_angle_deg: libm::atan(0.5).to_degrees() }
    }
}

impl Camera {
    /// Radius of the disc of ground that is seen.
    #[must_use]
    pub fn radius_m(self) -> f64 {
        self.altitude_m * libm::tan(self.half_angle_deg.to_radians())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_50_m_a_half_angle_of_26_6_degrees_shows_25_m() {
        assert!((Camera::default().radius_m() - 25.0).abs() < 1e-12);
        assert!((Camera::default().half_angle_deg - 26.6).abs() < 0.05);
    }
}
