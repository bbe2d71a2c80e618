//! Rolling: small arcs along the surface, by the balance of energy. Energy is never created.

use nalgebra::Vector3;

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

/// What a roll depends on besides the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    /// 1 + β.
    pub inertia: f64,
    pub gravity_mps2: f64,
    /// Speed across the surface up to which the body follows it, m/s.
    pub stop_mps: f64,
    /// Longest arc, metres.
    pub arc_m: f64,
    /// Most arcs of a hop.
    pub arcs_max: u32,
}

impl Rolling {
    /// Rolls from a point on a patch with a velocity along it. `arcs` counts those of the hop so far.
    // Long: one loop over arcs, whose state is seven values.
    #[inline]
    pub(crate) fn roll<F: Field>(
        &self,
        surface: &Surface<F>,
        patch: Patch,
        from: Vector3<f64>,
        velocity: Vector3<f64>,
        arcs: &mut u32,
    ) -> Rolled {
        let Self { inertia, gravity_mps2, stop_mps, arc_m, arcs_max } = *self;
        let mut position = from;
        let mut speed = libm::sqrt(velocity.norm_squared());
        let mut heading = if speed > 0.0 { velocity / speed } else { Vector3::zeros() };
        let (mut metres, mut seconds) = (0.0, 0.0);
        let mut patch = patch;
        let mut ground = surface.bilinear(patch);
        let (mut columns, mut rows) = (surface.columns(patch), surface.rows(patch));
        let mut stuck = 0;
        let ended =
            |position, velocity, metres, seconds, rest| Rolled { position, velocity, metres, seconds, rest };
        loop {
            *arcs += 1;
            if *arcs > arcs_max {
                return ended(position, heading * speed, metres, seconds, Rest::RolledAway);
            }
            let normal = ground.normal(position.x, position.y);
            let resistance = surface.soil(position.x, position.y).rolling * gravity_mps2 * normal.z;
            let downhill = tangential(Vector3::new(0.0, 0.0, -gravity_mps2), normal);
            let is_held = libm::sqrt(downhill.norm_squared()) <= resistance;
            let turned = tangential(heading * (speed * speed) + downhill * (arc_m / inertia), normal);
            let size = libm::sqrt(turned.norm_squared());
            let rests = if is_held { Rest::Rests } else { Rest::Caught };
            if size == 0.0 || (speed == 0.0 && is_held) || stuck == STUCK_MAX {
                return ended(position, Vector3::zeros(), metres, seconds, rests);
            }
            let straight = heading;
            heading = turned / size;
            let mut way = Way::of(position, heading, columns, rows);
            if way.border_m < ARC_LEAST * arc_m && speed > 0.0 {
                // In a crease gravity turns it back over the border that it has just crossed: it turns after this arc instead.
                let along = tangential(straight, normal);
                let ahead = along / libm::sqrt(along.norm_squared());
                let onward = Way::of(position, ahead, columns, rows);
                if onward.border_m.is_finite() && onward.border_m >= ARC_LEAST * arc_m {
                    (heading, way) = (ahead, onward);
                }
            }
            let ds = arc_m.min(way.border_m);
            stuck = if ds < ARC_LEAST * arc_m { stuck + 1 } else { 0 };
            let to = |metres: f64| {
                let (x, y) = (position.x + heading.x * metres, position.y + heading.y * metres);
                Vector3::new(x, y, ground.height_m(x, y))
            };
            let before = 0.5 * inertia * speed * speed;
            let end = to(ds);
            let after = before - (gravity_mps2 * (end.z - position.z) + resistance * ds);
            if after <= 0.0 && ds > 0.0 {
                // It stops within the arc: where the balance, quadratic along it, reaches 0.
                let [rise, bend] = ground.along(position, heading);
                let gone_m = stops_at(before, gravity_mps2 * rise + resistance, gravity_mps2 * bend).min(ds);
                position = to(gone_m);
                metres += gone_m;
                seconds += if speed > 0.0 { 2.0 * gone_m / speed } else { 0.0 };
                speed = 0.0;
                if gone_m < ARC_LEAST * arc_m {
                    return ended(position, Vector3::zeros(), metres, seconds, rests);
                }
                continue;
            }
            let faster = libm::sqrt((2.0 * after / inertia).max(0.0));
            position = end;
            metres += ds;
            seconds += if speed + faster > 0.0 { 2.0 * ds / (speed + faster) } else { 0.0 };
            speed = faster;
            if ds < way.border_m {
                continue;
            }
            let Some(next) = surface.beside(patch, way.columns, way.rows) else {
                return ended(position, heading * speed, metres, seconds, Rest::LeftMap);
            };
            patch = next;
            ground = surface.bilinear(patch);
            (columns, rows) = (surface.columns(patch), surface.rows(patch));
            let normal = ground.normal(position.x, position.y);
            let outward = heading.dot(&normal) * speed;
            if libm::fabs(outward) > stop_mps {
                return ended(position, heading * speed, metres, seconds, Rest::Bounces(patch));
            }
        }
    }
}

/// Arcs in a row in which a body does not get on before it rests there. At a corner it may cross two borders at once.
const STUCK_MAX: u32 = 4;

/// The way to the border of a patch.
struct Way {
    border_m: f64,
    /// Which patch is beyond: columns and rows on.
    columns: i32,
    rows: i32,
}

impl Way {
    #[inline]
    fn of(position: Vector3<f64>, heading: Vector3<f64>, columns: [f64; 2], rows: [f64; 2]) -> Self {
        let until = |at: f64, by: f64, [low, high]: [f64; 2]| {
            if by > 0.0 {
                ((high - at) / by).max(0.0)
            } else if by < 0.0 {
                ((low - at) / by).max(0.0)
            } else {
                f64::INFINITY
            }
        };
        let step = |reaches: bool, by: f64| if reaches { if by > 0.0 { 1 } else { -1 } } else { 0 };
        let (across, up) = (until(position.x, heading.x, columns), until(position.y, heading.y, rows));
        let border_m = across.min(up);
        Self { border_m, columns: step(across <= border_m, heading.x), rows: step(up <= border_m, heading.y) }
    }
}

/// The metres after which `before` − `first` s − `second` s² first falls to 0; infinite if it never does.
#[inline]
fn stops_at(before: f64, first: f64, second: f64) -> f64 {
    if before <= 0.0 {
        // It starts at rest: that root is divided out.
        return if first < 0.0 && second > 0.0 { -first / second } else { 0.0 };
    }
    let root = libm::sqrt((first * first + 4.0 * second * before).max(0.0));
    // The same root twice, each form without cancellation.
    if first > 0.0 {
        2.0 * before / (first + root)
    } else if second > 0.0 {
        (root - first) / (2.0 * second)
    } else {
        f64::INFINITY
    }
}
