//! Single impacts of a sphere on level ground: the grid that is compared.

use contact::{Body, Soil};
use nalgebra::Vector3;

/// The sphere: solid, a tenth of a metre.
pub const BODY: Body = Body { radius_m: 0.1, inertia: 0.4 };

/// Speed of every impact, m/s.
pub const SPEED_MPS: f64 = 1.0;

/// An impact on ground whose normal is z.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Normal restitution.
    pub restitution: f64,
    /// Coulomb friction.
    pub friction: f64,
    /// m/s, downwards and along x.
    pub velocity: Vector3<f64>,
    /// rad/s.
    pub spin: Vector3<f64>,
}

/// Velocity, m/s, and spin, rad/s, after an impact.
pub type After = [Vector3<f64>; 2];

impl Case {
    /// Incidence from 5° to 85° off the normal, restitution 0 to 1, friction 0 to 1.2, at rest and spinning about each axis.
    #[must_use]
    pub fn grid() -> Vec<Self> {
        let mut cases = Vec::new();
        for incidence_deg in (5..=85).step_by(10) {
            let incidence = f64::from(incidence_deg).to_radians();
            let velocity = Vector3::new(incidence.sin(), 0.0, -incidence.cos()) * SPEED_MPS;
            for restitution in [0.0, 0.2, 0.35, 0.5, 0.8, 1.0] {
                for friction in [0.0, 0.1, 0.3, 0.6, 1.2] {
                    for spin in
                        [[0.0; 3], [0.0, 8.0, 0.0], [0.0, -8.0, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 8.0]]
                    {
                        cases.push(Self { restitution, friction, velocity, spin: spin.into() });
                    }
                }
            }
        }
        cases
    }

    fn soil(&self) -> Soil {
        Soil { restitution: self.restitution, friction: self.friction, roughness_rad: 0.0, ..Soil::HARD }
    }

    /// The impact as the contact engine has it.
    #[must_use]
    pub fn ours(&self) -> After {
        self.with_friction(self.friction)
    }

    /// The same where friction is limited by the impulse that stops the sphere, and not by that which throws it back.
    #[must_use]
    pub fn ours_with_friction_of_the_stop(&self) -> After {
        self.with_friction(self.friction / (1.0 + self.restitution))
    }

    fn with_friction(&self, friction: f64) -> After {
        let soil = Soil { friction, ..self.soil() };
        // Without gravity: an impact is an instant.
        contact::impact(&BODY, &soil, 0.0, [self.velocity, self.spin], Vector3::z(), Vector3::z())
    }

    /// Whether friction stops all slip.
    #[must_use]
    pub fn sticks(&self) -> bool {
        let arm = Vector3::z() * -BODY.radius_m;
        let mut slip = self.velocity + self.spin.cross(&arm);
        slip.z = 0.0;
        BODY.sticking() * slip.norm() <= self.friction * -self.velocity.z
    }
}
