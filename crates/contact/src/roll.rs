//! Rolling: small arcs along the surface, by the balance of energy. Energy is never created.

use nalgebra::Vector3;

use crate::body::Body;
use crate::bounds::ARC_LEAST;
use crate::impact::tangential;
use crate::surface::{Field, Patch, Surface};

/// How a roll ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rest {
    /// At rest on ground that holds it.
    Rests,
    /// In a crease or a pit, or at the foot of a wall, on ground that is too steep to hold it.
    Caught,
    /// The ground falls away, or stands in the way: it flies or hits.
    Bounces(Patch),
    /// Over the border of the ground.
    LeftMap,
    /// After more arcs than are followed.
    RolledAway,
}

/// A roll: where it has come to, by how long a way and in which time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolled {
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub metres: f64,
    pub seconds: f64,
    pub rest: Rest,
}

/// Rolls from a point on the ground with a velocity along it. `arcs` counts those of the hop so far.
// Long: one loop over arcs, whose state is seven values.
#[allow(clippy::too_many_arguments, reason = "a place, a motion and what is left of it")]
pub(crate) fn roll<F: Field>(
    surface: &Surface<F>,
    body: &Body,
    gravity_mps2: f64,
    arc_m: f64,
    from: Vector3<f64>,
    velocity: Vector3<f64>,
    arcs: &mut u32,
    arcs_max: u32,
) -> Rolled {
    let inertia = 1.0 + body.inertia;
    let stop_mps = body.stop_mps(gravity_mps2);
    let mut position = from;
    let mut speed = libm::sqrt(velocity.norm_squared());
    let mut heading = if speed > 0.0 { velocity / speed } else { Vector3::zeros() };
    let (mut metres, mut seconds) = (0.0, 0.0);
    let mut patch = surface.patch(position.x, position.y);
    let ended =
        |position, velocity, metres, seconds, rest| Rolled { position, velocity, metres, seconds, rest };
    loop {
        *arcs += 1;
        if *arcs > arcs_max {
            return ended(position, heading * speed, metres, seconds, Rest::RolledAway);
        }
        let ground = surface.bilinear(patch);
        let normal = ground.normal(position.x, position.y);
        let soil = surface.soil(position.x, position.y);
        let downhill = tangential(Vector3::new(0.0, 0.0, -gravity_mps2), normal);
        let towards = tangential(heading * (speed * speed) + downhill * (arc_m / inertia), normal);
        let size = libm::sqrt(towards.norm_squared());
        let is_held = libm::sqrt(downhill.norm_squared()) <= soil.rolling * gravity_mps2 * normal.z;
        if size == 0.0 || (speed == 0.0 && is_held) {
            let rest = if is_held { Rest::Rests } else { Rest::Caught };
            return ended(position, Vector3::zeros(), metres, seconds, rest);
        }
        heading = towards / size;
        // The arc ends at the border of the patch at the latest.
        let [west, east, south, north] = surface.borders(patch);
        let until = |at: f64, by: f64, low: f64, high: f64| {
            if by > 0.0 {
                (high - at) / by
            } else if by < 0.0 {
                (low - at) / by
            } else {
                f64::INFINITY
            }
        };
        let across = until(position.x, heading.x, west, east).max(0.0);
        let up = until(position.y, heading.y, south, north).max(0.0);
        let border_m = across.min(up);
        let ds = arc_m.min(border_m);
        let to = |share: f64| {
            let (x, y) = (position.x + heading.x * ds * share, position.y + heading.y * ds * share);
            Vector3::new(x, y, ground.height_m(x, y))
        };
        let before = 0.5 * inertia * speed * speed;
        let spent = |share: f64| {
            let rise_m = to(share).z - position.z;
            gravity_mps2 * rise_m + soil.rolling * gravity_mps2 * normal.z * ds * share
        };
        let after = before - spent(1.0);
        if after <= 0.0 && ds > 0.0 {
            // It stops within the arc: where the balance reaches 0.
            let share = stops_at(|share| before - spent(share));
            let gone_m = ds * share;
            position = to(share);
            metres += gone_m;
            seconds += if speed > 0.0 { 2.0 * gone_m / speed } else { 0.0 };
            speed = 0.0;
            if gone_m < ARC_LEAST * arc_m {
                let soil = surface.soil(position.x, position.y);
                let slope = tangential(Vector3::new(0.0, 0.0, -gravity_mps2), normal);
                let holds = libm::sqrt(slope.norm_squared()) <= soil.rolling * gravity_mps2 * normal.z;
                let rest = if holds { Rest::Rests } else { Rest::Caught };
                return ended(position, Vector3::zeros(), metres, seconds, rest);
            }
            continue;
        }
        let faster = libm::sqrt((2.0 * after / inertia).max(0.0));
        position = to(1.0);
        metres += ds;
        seconds += if speed + faster > 0.0 { 2.0 * ds / (speed + faster) } else { 0.0 };
        speed = faster;
        if ds < border_m {
            continue;
        }
        let step = |reaches: bool, by: f64| if reaches { if by > 0.0 { 1 } else { -1 } } else { 0 };
        let (columns, rows) = (step(across <= border_m, heading.x), step(up <= border_m, heading.y));
        let Some(next) = surface.beside(patch, columns, rows) else {
            return ended(position, heading * speed, metres, seconds, Rest::LeftMap);
        };
        patch = next;
        let normal = surface.bilinear(patch).normal(position.x, position.y);
        let outward = heading.dot(&normal) * speed;
        if libm::fabs(outward) > stop_mps {
            return ended(position, heading * speed, metres, seconds, Rest::Bounces(patch));
        }
    }
}

/// The share of an arc, 0 to 1, at which a balance that ends at or below 0 first gets there, by bisection: 52 halvings.
fn stops_at(balance: impl Fn(f64) -> f64) -> f64 {
    if balance(0.0) <= 0.0 && balance(ARC_LEAST) <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..52 {
        let middle = 0.5 * (low + high);
        if balance(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
