//! A whole hop: launch, flight, impacts, rolling, rest.

use nalgebra::Vector3;

use crate::body::Body;
use crate::bounds::{ARCS_A_CELL, ARCS_MAX, IMPACTS_MAX, IMPACTS_TOLD};
use crate::flight::{Landing, fly};
use crate::impact::{impact, tangential};
use crate::noise::Noise;
use crate::roll::{Rest, roll};
use crate::surface::{Field, Surface};

/// How a hop ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At rest on ground that holds it.
    Rest,
    /// At rest in a crease or a pit, or at the foot of a wall.
    Caught,
    /// It did not get off the ground.
    NoLaunch,
    /// Over the border of the ground.
    LeftMap,
    /// It rolled on beyond [`crate::bounds::ARCS_MAX`], or flew on beyond [`crate::bounds::PATCHES_MAX`].
    RolledAway,
    /// It bounced on beyond [`IMPACTS_MAX`].
    BouncedOn,
}

/// An impact: where, and the velocities before and after, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Metres.
    pub position: Vector3<f64>,
    /// m/s.
    pub before: Vector3<f64>,
    /// m/s.
    pub after: Vector3<f64>,
    /// Since the launch, seconds.
    pub seconds: f64,
}

/// What a hop has come to.
#[derive(Clone, Debug, PartialEq)]
pub struct Hop {
    /// How it ends.
    pub end: End,
    /// Where, metres.
    pub position: Vector3<f64>,
    /// Velocity at the launch, m/s.
    pub launched: Vector3<f64>,
    /// The first [`IMPACTS_TOLD`] impacts.
    pub impacts: Vec<Impact>,
    /// All of them.
    pub impact_count: u32,
    /// Way rolled, metres.
    pub rolled_m: f64,
    /// From launch to rest, seconds.
    pub seconds: f64,
}

/// Where a hop takes place.
#[derive(Debug)]
pub struct Place<'a, F> {
    /// The ground.
    pub surface: &'a Surface<F>,
    /// The body.
    pub body: &'a Body,
    /// m/s², above 0.
    pub gravity_mps2: f64,
    /// Length of the hop that is aimed, metres.
    pub hop_m: f64,
}

/// What of a hop is followed at most.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Impacts.
    pub impacts: u32,
    /// Arcs of rolling.
    pub arcs: u32,
    /// Whether it is followed to its first contact only, which counts as rest.
    pub to_first_contact: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Self { impacts: IMPACTS_MAX, arcs: ARCS_MAX, to_first_contact: false }
    }
}

impl<F: Field> Place<'_, F> {
    /// Cuts the part of a launch velocity along the ground to what the foot can hold; `None` if it does not leave the ground.
    #[must_use]
    pub fn foothold(&self, from: Vector3<f64>, velocity: Vector3<f64>) -> Option<Vector3<f64>> {
        let normal = self.surface.normal(from.x, from.y);
        let upward = velocity.dot(&normal);
        if upward <= 0.0 {
            return None;
        }
        let along = tangential(velocity, normal);
        let along_mps = libm::sqrt(along.norm_squared());
        let most = self.surface.soil(from.x, from.y).foot * upward;
        let held = if along_mps > most { along * (most / along_mps) } else { along };
        Some(normal * upward + held)
    }

    /// Hops from a point on the ground with a velocity that the foot holds. Impact k takes the numbers 3 + 2 k and 4 + 2 k of
    /// `noise` for its roughness.
    #[must_use]
    pub fn hop(&self, from: Vector3<f64>, launched: Vector3<f64>, noise: &mut Noise) -> Hop {
        self.hop_within(from, launched, noise, &Limits::default())
    }

    /// As [`Place::hop`], followed within limits.
    // Long: one loop over flights, impacts and rolls.
    #[must_use]
    pub fn hop_within(
        &self,
        from: Vector3<f64>,
        launched: Vector3<f64>,
        noise: &mut Noise,
        limits: &Limits,
    ) -> Hop {
        let Self { surface, body, gravity_mps2, hop_m } = *self;
        let arc_m = surface.cell_m().min(hop_m) / ARCS_A_CELL;
        let stop_mps = body.stop_mps(gravity_mps2);
        let mut hop = Hop {
            end: End::Rest,
            position: from,
            launched,
            impacts: Vec::new(),
            impact_count: 0,
            rolled_m: 0.0,
            seconds: 0.0,
        };
        let (mut patches, mut arcs) = (0, 0);
        let (mut velocity, mut spin) = (launched, Vector3::zeros());
        let mut patch = surface.patch(from.x, from.y);
        loop {
            let flown = fly(surface, patch, hop.position, velocity, gravity_mps2, &mut patches);
            (hop.position, hop.seconds) = (flown.position, hop.seconds + flown.seconds);
            velocity = flown.velocity;
            patch = match flown.landing {
                Landing::Ground(patch) => patch,
                Landing::LeftMap => return Hop { end: End::LeftMap, ..hop },
                Landing::Endless => return Hop { end: End::RolledAway, ..hop },
            };
            if limits.to_first_contact {
                return hop;
            }
            loop {
                if hop.impact_count == limits.impacts {
                    return Hop { end: End::BouncedOn, ..hop };
                }
                let ground = surface.bilinear(patch);
                let (x, y) = (hop.position.x, hop.position.y);
                hop.position.z = ground.height_m(x, y);
                let (normal, soil) = (ground.normal(x, y), surface.soil(x, y));
                let rough = {
                    let first = 3 + 2 * u64::from(hop.impact_count);
                    let lean = Vector3::new(noise.normal(first), noise.normal(first + 1), 0.0);
                    let long = normal + lean * soil.roughness_rad;
                    long / libm::sqrt(long.norm_squared())
                };
                let before = velocity;
                [velocity, spin] = impact(body, soil, gravity_mps2, [velocity, spin], normal, rough);
                if hop.impacts.len() < IMPACTS_TOLD {
                    let (position, seconds) = (hop.position, hop.seconds);
                    hop.impacts.push(Impact { position, before, after: velocity, seconds });
                }
                hop.impact_count += 1;
                if velocity.dot(&normal) >= stop_mps {
                    break;
                }
                // It rolls without slipping, and gains nothing by that.
                let along = tangential(velocity, normal);
                let slip = tangential(along + spin.cross(&(normal * -body.radius_m)), normal);
                let rolled = roll(
                    surface,
                    body,
                    gravity_mps2,
                    arc_m,
                    hop.position,
                    along - slip * body.sticking(),
                    &mut arcs,
                    limits.arcs,
                );
                hop.position = rolled.position;
                hop.rolled_m += rolled.metres;
                hop.seconds += rolled.seconds;
                velocity = rolled.velocity;
                match rolled.rest {
                    Rest::Rests => return hop,
                    Rest::Caught => return Hop { end: End::Caught, ..hop },
                    Rest::LeftMap => return Hop { end: End::LeftMap, ..hop },
                    Rest::RolledAway => return Hop { end: End::RolledAway, ..hop },
                    Rest::Bounces(next) => {
                        patch = next;
                        let normal = surface.bilinear(patch).normal(hop.position.x, hop.position.y);
                        // As it rolls, so it spins.
                        spin = normal.cross(&velocity) / body.radius_m;
                        if velocity.dot(&normal) > 0.0 {
                            break;
                        }
                    }
                }
            }
        }
    }
}
