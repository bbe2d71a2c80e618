//! Hops over ground of any shape, and by how much their energy grows. For the tests of energy and the bench of endings.

use contact::{Body, End, Ending, Field, Limits, Noise, Place, Soil, Surface};
use nalgebra::Vector3;

/// Columns and rows.
pub const SIDE: usize = 16;

/// Share of v² + g (|z| + extent of the map) by which rounding may raise the energy.
pub const GROWTH_MAX: f64 = 1e-12;

/// Ground with two soils in a checkerboard of 4 × 4 cells.
pub struct Ground {
    pub cell_m: f64,
    pub heights_m: Vec<f64>,
    pub soils: [Soil; 2],
}

impl Field for Ground {
    fn size(&self) -> [usize; 2] {
        [SIDE; 2]
    }

    fn cell_m(&self) -> f64 {
        self.cell_m
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        self.heights_m[row * SIDE + column]
    }

    fn soil(&self, column: usize, row: usize) -> &Soil {
        &self.soils[(column / 4 + row / 4) % 2]
    }
}

/// A hop.
pub struct Flown {
    pub ending: Ending,
    /// The largest growth of energy between two of its contacts, the spin's included, as a share of what [`GROWTH_MAX`] is of.
    pub growth: f64,
}

/// A hop of `body` from a place at a velocity; `None` if it does not leave the ground.
pub fn fly(
    surface: &Surface<Ground>,
    body: &Body,
    gravity_mps2: f64,
    [x, y]: [f64; 2],
    velocity: [f64; 3],
    noise: &mut Noise,
) -> Option<Flown> {
    let start = Vector3::new(x, y, surface.height_m(x, y));
    let place = Place { surface, body, gravity_mps2, hop_m: 1.0 };
    let launched = place.foothold(start, velocity.into())?;
    let energy = |at: Vector3<f64>, velocity: Vector3<f64>, spin: Vector3<f64>| {
        let turning = body.inertia * body.radius_m * body.radius_m * spin.norm_squared();
        0.5 * (velocity.norm_squared() + turning) + gravity_mps2 * at.z
    };
    let mut last = energy(start, launched, Vector3::zeros());
    let mut growth = 0.0_f64;
    let ending = place.follow(start, launched, noise, &Limits::default(), |impact| {
        let before = energy(impact.position, impact.before, impact.spins[0]);
        let after = energy(impact.position, impact.after, impact.spins[1]);
        growth = growth.max(before - last).max(after - before);
        last = after;
    });
    if matches!(ending.end, End::Rest | End::Caught) {
        growth = growth.max(gravity_mps2 * ending.position.z - last);
    }
    let extent_m = SIDE as f64 * surface.cell_m();
    let scale = launched.norm_squared() + gravity_mps2 * (start.z.abs() + extent_m);
    Some(Flown { ending, growth: growth / scale })
}
