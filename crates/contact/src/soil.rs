//! How a soil takes a body.

/// Contact parameters of a soil, all without unit unless said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Soil {
    /// Normal restitution e₀, 0 to 1.
    pub restitution: f64,
    /// Impact speed beyond which restitution falls, m/s; infinite: it never does.
    pub restitution_speed_mps: f64,
    /// Gravity at which restitution has fallen to a half, m/s²; infinite: it does not depend on gravity.
    pub restitution_gravity_mps2: f64,
    /// Coulomb friction μ at an impact.
    pub friction: f64,
    /// Rolling resistance c: tangent of the steepest slope on which the body rests.
    pub rolling: f64,
    /// Grip of the foot at a launch.
    pub foot: f64,
    /// Spread of the normal at an impact, radians.
    pub roughness_rad: f64,
}

impl Soil {
    /// Hard ground of planets, on which a body rests up to 30°.
    pub const HARD: Self = Self {
        restitution: 0.35,
        restitution_speed_mps: f64::INFINITY,
        restitution_gravity_mps2: f64::INFINITY,
        friction: 0.6,
        rolling: 0.577,
        foot: 1.2,
        roughness_rad: 0.15,
    };

    /// Sand of planets: no rebound, and no foothold at 45°.
    pub const SAND: Self =
        Self { restitution: 0.0, rolling: 0.7, foot: 0.7, roughness_rad: 0.05, ..Self::HARD };

    /// e(v_n, g) = e₀ min(1, (v_e / v_n)^¼) / (1 + g / g_e), at a normal speed of v_n above 0.
    #[must_use]
    pub fn restitution_at(&self, normal_mps: f64, gravity_mps2: f64) -> f64 {
        let slowed = if normal_mps > self.restitution_speed_mps {
            libm::sqrt(libm::sqrt(self.restitution_speed_mps / normal_mps))
        } else {
            1.0
        };
        self.restitution * slowed / (1.0 + gravity_mps2 / self.restitution_gravity_mps2)
    }
}
