//! The body that hops.

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Radius, metres; well below the edge of a cell, since the contact point is taken to lie on the ground.
    pub radius_m: f64,
    /// Inertia over m R²: 0.4 for a solid sphere, 2/3 for a shell.
    pub inertia: f64,
}

impl Body {
    /// β / (1 + β): the share of the slip that sticking takes away.
    #[must_use]
    pub fn sticking(&self) -> f64 {
        self.inertia / (1.0 + self.inertia)
    }

    /// The normal speed after an impact below which bouncing ends, m/s: that of a bounce as high as a hundredth of the radius, at
    /// most a millimetre.
    #[must_use]
    pub fn stop_mps(&self, gravity_mps2: f64) -> f64 {
        libm::sqrt(2.0 * gravity_mps2 * (self.radius_m / 100.0).min(1.0e-3))
    }
}
