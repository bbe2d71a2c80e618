//! Flight from one contact to the next: exact, patch by patch.
//!
//! Within a patch the ground is quadratic along the path, and so is the arc; their difference f = height over ground has one root at
//! which it falls. What is walked is the projection of the arc on the lattice of patches.

use nalgebra::Vector3;

use crate::surface::{Bilinear, Field, Patch, Surface};

/// How a flight ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Landing {
    /// On the ground in that patch.
    Ground(Patch),
    /// Over the border of the ground.
    LeftMap,
    /// After more patches than are walked.
    Endless,
}

/// A flight: seconds, and where and how fast it ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flown {
    pub seconds: f64,
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub landing: Landing,
}

/// The height over ground of an arc in a patch: f0 + f1 t + f2 t².
struct Clearance {
    f0: f64,
    f1: f64,
    f2: f64,
}

impl Clearance {
    fn of(ground: &Bilinear, from: Vector3<f64>, velocity: Vector3<f64>, gravity_mps2: f64) -> Self {
        let [east, north] = ground.gradient(from.x, from.y);
        Self {
            f0: from.z - ground.height_m(from.x, from.y),
            f1: velocity.z - east * velocity.x - north * velocity.y,
            f2: -0.5 * gravity_mps2 - ground.d * velocity.x * velocity.y,
        }
    }

    /// When it falls to 0, if it does; `None` if it rises or never gets there.
    fn falls_at(&self) -> Option<f64> {
        let Self { f0, f1, f2 } = *self;
        let under_root = f1 * f1 - 4.0 * f2 * f0;
        if under_root < 0.0 {
            return None;
        }
        let root = libm::sqrt(under_root);
        // The same root twice, each form without cancellation.
        let at = if f1 < 0.0 { 2.0 * f0 / (root - f1) } else { -0.5 * (f1 + root) / f2 };
        at.is_finite().then_some(at)
    }
}

/// Flies from a point on the ground until the next contact. The patch is that of the contact before.
pub(crate) fn fly<F: Field>(
    surface: &Surface<F>,
    patch: Patch,
    from: Vector3<f64>,
    velocity: Vector3<f64>,
    gravity_mps2: f64,
    patches: &mut u32,
) -> Flown {
    let at = |seconds: f64| {
        let fall = Vector3::new(0.0, 0.0, -0.5 * gravity_mps2 * seconds * seconds);
        from + velocity * seconds + fall
    };
    let ended = |seconds: f64, landing: Landing| {
        let fallen = Vector3::new(0.0, 0.0, -gravity_mps2 * seconds);
        Flown { seconds, position: at(seconds), velocity: velocity + fallen, landing }
    };
    let mut patch = patch;
    let mut entered = 0.0;
    let mut is_departure = true;
    loop {
        let ground = surface.bilinear(patch);
        let clearance = Clearance::of(&ground, from, velocity, gravity_mps2);
        let Clearance { f0: _, f1, f2 } = clearance;
        let (exit, columns, rows) = leaves(surface, patch, from, velocity, entered);
        if is_departure && exit <= 0.0 {
            // It stands on the border, and goes the other way: the patch is the next one.
            let Some(next) = surface.beside(patch, columns, rows) else {
                return ended(0.0, Landing::LeftMap);
            };
            patch = next;
            continue;
        }
        let touches = if is_departure {
            // It begins on the ground: that root is divided out.
            if f1 < 0.0 {
                Some(0.0)
            } else if f2 < 0.0 {
                Some(-f1 / f2)
            } else {
                None
            }
        } else {
            let over = clearance.f0 + entered * (f1 + entered * f2);
            let rises = f1 + 2.0 * f2 * entered;
            if over <= 0.0 && rises < 0.0 {
                Some(entered)
            } else {
                clearance.falls_at().filter(|at| *at > entered)
            }
        };
        if let Some(at) = touches.filter(|at| *at <= exit) {
            return ended(at, Landing::Ground(patch));
        }
        *patches += 1;
        if *patches > crate::bounds::PATCHES_MAX || exit.is_infinite() {
            return ended(entered, Landing::Endless);
        }
        let Some(next) = surface.beside(patch, columns, rows) else {
            return ended(exit, Landing::LeftMap);
        };
        (patch, entered, is_departure) = (next, exit, false);
    }
}

/// When the path leaves a patch, and to which side.
fn leaves<F: Field>(
    surface: &Surface<F>,
    patch: Patch,
    from: Vector3<f64>,
    velocity: Vector3<f64>,
    entered: f64,
) -> (f64, i32, i32) {
    let [west, east, south, north] = surface.borders(patch);
    let along = |from: f64, speed: f64, low: f64, high: f64| {
        if speed > 0.0 {
            (((high - from) / speed).max(entered), 1)
        } else if speed < 0.0 {
            (((low - from) / speed).max(entered), -1)
        } else {
            (f64::INFINITY, 0)
        }
    };
    let (across, column) = along(from.x, velocity.x, west, east);
    let (up, row) = along(from.y, velocity.y, south, north);
    if across < up {
        (across, column, 0)
    } else if up < across {
        (up, 0, row)
    } else {
        (across, column, row)
    }
}
