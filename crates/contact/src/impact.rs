//! An impact: what the ground does to velocity and spin in an instant.

use nalgebra::Vector3;

use crate::body::Body;
use crate::soil::Soil;

/// Velocity, m/s, and spin, rad/s, after the impact of a body on ground with the outward normal `normal` of the surface and `rough`,
/// that of the spot it hits; both of length 1.
///
/// Sticking or sliding by Coulomb's law, without tangential restitution.
#[must_use]
#[inline]
pub fn impact(
    body: &Body,
    soil: &Soil,
    gravity_mps2: f64,
    [velocity, spin]: [Vector3<f64>; 2],
    normal: Vector3<f64>,
    rough: Vector3<f64>,
) -> [Vector3<f64>; 2] {
    let spot = if velocity.dot(&rough) < 0.0 { rough } else { normal };
    let into = -velocity.dot(&spot);
    if into <= 0.0 {
        return [velocity, spin];
    }
    let normal_impulse = (1.0 + soil.restitution_at(into, gravity_mps2)) * into;
    let arm = spot * -body.radius_m;
    let slip = tangential(velocity + spin.cross(&arm), spot);
    let slip_mps = libm::sqrt(slip.norm_squared());
    let size = (body.sticking() * slip_mps).min(soil.friction * normal_impulse);
    let friction = if slip_mps > 0.0 { slip * (-size / slip_mps) } else { Vector3::zeros() };
    let mut velocity = velocity + spot * normal_impulse + friction;
    let spin = spin + arm.cross(&friction) / (body.inertia * body.radius_m * body.radius_m);
    // A rough spot may throw it into the ground beside.
    let inward = velocity.dot(&normal);
    if inward < 0.0 {
        velocity -= normal * inward;
    }
    [velocity, spin]
}

/// The part of a vector along a surface.
#[inline]
pub(crate) fn tangential(vector: Vector3<f64>, normal: Vector3<f64>) -> Vector3<f64> {
    vector - normal * vector.dot(&normal)
}
