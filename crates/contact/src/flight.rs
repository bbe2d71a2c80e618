//! Flight from one contact to the next: exact, patch by patch.
//!
//! Within a patch the ground is quadratic along the path, and so is the arc; their difference f = height over ground has one root at
//! which it falls. What is walked is the projection of the arc on the lattice of patches.

use nalgebra::Vector3;

use crate::surface::{Bilinear, Field, Patch, Surface};

/// How a flight ends.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Landing {
    /// On the ground in that patch.
    Ground(Patch, Bilinear),
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
    #[inline]
    fn of(ground: &Bilinear, arc: &Arc) -> Self {
        let Arc { from, velocity, gravity_mps2 } = arc;
        let [east, north] = ground.gradient(from.x, from.y);
        Self {
            f0: from.z - ground.height_m(from.x, from.y),
            f1: velocity.z - east * velocity.x - north * velocity.y,
            f2: -0.5 * gravity_mps2 - ground.d * velocity.x * velocity.y,
        }
    }

    /// When it falls to 0 after a departure from the ground: that root, at 0, is divided out.
    #[inline]
    fn falls_again_at(&self) -> Option<f64> {
        if self.f1 < 0.0 {
            Some(0.0)
        } else if self.f2 < 0.0 {
            Some(-self.f1 / self.f2)
        } else {
            None
        }
    }

    /// When it falls to 0 after the entry of a patch.
    #[inline]
    fn falls_at(&self, entered: f64) -> Option<f64> {
        let Self { f0, f1, f2 } = *self;
        let over = f0 + entered * (f1 + entered * f2);
        if over <= 0.0 && f1 + 2.0 * f2 * entered < 0.0 {
            return Some(entered);
        }
        let under_root = f1 * f1 - 4.0 * f2 * f0;
        if under_root < 0.0 {
            return None;
        }
        let root = libm::sqrt(under_root);
        // The same root twice, each form without cancellation.
        let at = if f1 < 0.0 { 2.0 * f0 / (root - f1) } else { -0.5 * (f1 + root) / f2 };
        (at.is_finite() && at > entered).then_some(at)
    }
}

/// A parabola.
struct Arc {
    from: Vector3<f64>,
    velocity: Vector3<f64>,
    gravity_mps2: f64,
}

impl Arc {
    #[inline]
    fn ended(&self, seconds: f64, landing: Landing) -> Flown {
        let fall = Vector3::new(0.0, 0.0, -0.5 * self.gravity_mps2 * seconds * seconds);
        let faster = Vector3::new(0.0, 0.0, -self.gravity_mps2 * seconds);
        let position = self.from + self.velocity * seconds + fall;
        Flown { seconds, position, velocity: self.velocity + faster, landing }
    }
}

/// The walk of an arc over the borders between patches along one axis.
struct Borders {
    from: f64,
    speed: f64,
    /// Patches on, by one: east or north 1, west or south −1, 0 if it goes neither way.
    step: i32,
    /// When it reaches the next border, seconds; infinite if never.
    reaches: f64,
}

impl Borders {
    #[inline]
    fn new(from: f64, speed: f64, [low, high]: [f64; 2]) -> Self {
        let step = if speed > 0.0 { 1 } else { -i32::from(speed < 0.0) };
        let mut borders = Self { from, speed, step, reaches: f64::INFINITY };
        borders.enter([low, high]);
        borders
    }

    /// The next border is one of those of the patch that it is in now.
    #[inline]
    fn enter(&mut self, [low, high]: [f64; 2]) {
        if self.step != 0 {
            let border = if self.step > 0 { high } else { low };
            self.reaches = (border - self.from) / self.speed;
        }
    }
}

/// Flies from a point on the ground until the next contact. The patch is that of the contact before.
#[inline]
pub(crate) fn fly<F: Field>(
    surface: &Surface<F>,
    patch: Patch,
    from: Vector3<f64>,
    velocity: Vector3<f64>,
    gravity_mps2: f64,
    patches: &mut u32,
) -> Flown {
    let arc = Arc { from, velocity, gravity_mps2 };
    let mut patch = patch;
    let mut across = Borders::new(from.x, velocity.x, surface.columns(patch));
    let mut up = Borders::new(from.y, velocity.y, surface.rows(patch));
    let mut entered = 0.0;
    let mut is_departure = true;
    loop {
        let (reaches, columns, rows) = {
            let (column, row) = (across.reaches.max(entered), up.reaches.max(entered));
            if column < row {
                (column, across.step, 0)
            } else if row < column {
                (row, 0, up.step)
            } else {
                (column, across.step, up.step)
            }
        };
        // Whoever stands on the border and goes the other way is in the next patch.
        if !is_departure || reaches > 0.0 {
            let ground = surface.bilinear(patch);
            let clearance = Clearance::of(&ground, &arc);
            let falls = if is_departure { clearance.falls_again_at() } else { clearance.falls_at(entered) };
            if let Some(at) = falls
                && at <= reaches
            {
                return arc.ended(at, Landing::Ground(patch, ground));
            }
            *patches += 1;
            if *patches > crate::bounds::PATCHES_MAX || reaches.is_infinite() {
                return arc.ended(entered, Landing::Endless);
            }
            (entered, is_departure) = (reaches, false);
        }
        let Some(next) = surface.beside(patch, columns, rows) else {
            return arc.ended(entered, Landing::LeftMap);
        };
        patch = next;
        if columns != 0 {
            across.enter(surface.columns(patch));
        }
        if rows != 0 {
            up.enter(surface.rows(patch));
        }
    }
}
