//! A hopper with the parameters of a preset on a plane of one soil.

use contact::{Aim, Hop, Known, Noise, Place, Plane, Soil, Surface};
use nalgebra::Vector3;
use scenario::{ContactParameters, ContactRules, Preset};

/// Length of the hops, metres.
pub const HOP_M: f64 = 1.0;

/// The soil of a preset as the engine has it.
#[must_use]
pub fn soil_of(preset: Preset, soil: contract::Soil) -> Soil {
    preset.soils()[soil as usize]
}

/// A hopper on a plane.
#[derive(Debug)]
pub struct HopperOn {
    surface: Surface<Plane>,
    parameters: ContactParameters,
    known: Known,
    gravity_mps2: f64,
    middle_m: f64,
}

impl HopperOn {
    /// The hopper of the papers on ground of a preset with that gradient: (∂h/∂x, ∂h/∂y). It hops along x.
    #[must_use]
    pub fn new(preset: Preset, kind: contract::Soil, gradient: [f64; 2]) -> Self {
        let (soil, gravity_mps2) = (soil_of(preset, kind), preset.gravity_mps2());
        let plane = Plane::new(HOP_M, gradient, soil);
        Self {
            middle_m: plane.middle_m(),
            surface: Surface::new(plane),
            parameters: ContactRules { preset, ..ContactRules::default() }.parameters(),
            known: Known { gradient, soil },
            gravity_mps2,
        }
    }

    /// Hops along x from a point, metres from the middle of its cell, to the middle of the next: where it ends, metres from the middle of
    /// the cell of departure; `None` if it does not leave the ground.
    #[must_use]
    pub fn hop(&self, offset_m: [f64; 2], noise: &mut Noise) -> Option<Hop> {
        let Self { surface, parameters, known, gravity_mps2, middle_m } = self;
        let ContactParameters { body, errors, .. } = parameters;
        let [x, y] = offset_m.map(|metres| metres + middle_m);
        let target_m = [HOP_M - offset_m[0], -offset_m[1]];
        let elevation_rad = std::f64::consts::FRAC_PI_4;
        // At 45° v² is g d.
        let speed_max_mps = parameters.speed_max_mps(libm::sqrt(gravity_mps2 * HOP_M));
        let aim = Aim { target_m, elevation_rad, speed_max_mps };
        let trimmed_mps = aim.trimmed_mps(body, *gravity_mps2, known);
        let launch = aim.launch(trimmed_mps, errors, noise);
        let place = Place { surface, body, gravity_mps2: *gravity_mps2, hop_m: HOP_M };
        let start = Vector3::new(x, y, surface.height_m(x, y));
        let mut hop = place.hop(start, place.foothold(start, launch)?, noise);
        hop.position.x -= middle_m;
        hop.position.y -= middle_m;
        Some(hop)
    }
}
