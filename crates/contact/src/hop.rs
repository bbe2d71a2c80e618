//! A whole hop: launch, flight, impacts, rolling, rest.

use nalgebra::Vector3;

use crate::body::Body;
use crate::bounds::{ARCS_A_CELL, ARCS_MAX, IMPACTS_MAX, IMPACTS_TOLD};
use crate::flight::{Landing, fly};
use crate::impact::{impact, tangential};
use crate::noise::Noise;
use crate::roll::{Rest, Rolling};
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
    /// Spin before and after, rad/s.
    pub spins: [Vector3<f64>; 2],
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

/// How a hop ends, without its impacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ending {
    /// How it ends.
    pub end: End,
    /// Where, metres.
    pub position: Vector3<f64>,
    /// All impacts.
    pub impact_count: u32,
    /// Way rolled, metres.
    pub rolled_m: f64,
    /// From launch to rest, seconds.
    pub seconds: f64,
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
        let mut impacts = Vec::with_capacity(IMPACTS_TOLD);
        let tell = |impact: &Impact| {
            if impacts.len() < IMPACTS_TOLD {
                impacts.push(*impact);
            }
        };
        let ending = self.follow(from, launched, noise, &Limits::default(), tell);
        let Ending { end, position, impact_count, rolled_m, seconds } = ending;
        Hop { end, position, launched, impacts, impact_count, rolled_m, seconds }
    }

    /// As [`Place::hop`], followed within limits, with each impact told as it happens and none kept.
    // Long: one loop over flights, impacts and rolls.
    #[must_use]
    pub fn follow(
        &self,
        from: Vector3<f64>,
        launched: Vector3<f64>,
        noise: &mut Noise,
        limits: &Limits,
        mut tell: impl FnMut(&Impact),
    ) -> Ending {
        let Self { surface, body, gravity_mps2, hop_m } = *self;
        let stop_mps = body.stop_mps(gravity_mps2);
        let rolling = Rolling {
            inertia: 1.0 + body.inertia,
            gravity_mps2,
            stop_mps,
            arc_m: surface.cell_m().min(hop_m) / ARCS_A_CELL,
            arcs_max: limits.arcs,
        };
        let mut hop = Ending { end: End::Rest, position: from, impact_count: 0, rolled_m: 0.0, seconds: 0.0 };
        let (mut patches, mut arcs) = (0, 0);
        let (mut velocity, mut spin) = (launched, Vector3::zeros());
        let mut patch = surface.patch(from.x, from.y);
        loop {
            let flown = fly(surface, patch, hop.position, velocity, gravity_mps2, &mut patches);
            (hop.position, hop.seconds) = (flown.position, hop.seconds + flown.seconds);
            velocity = flown.velocity;
            let mut ground = match flown.landing {
                Landing::Ground(on, ground) => {
                    patch = on;
                    ground
                }
                Landing::LeftMap => return Ending { end: End::LeftMap, ..hop },
                Landing::Endless => return Ending { end: End::RolledAway, ..hop },
            };
            if limits.to_first_contact {
                return hop;
            }
            loop {
                if hop.impact_count == limits.impacts {
                    return Ending { end: End::BouncedOn, ..hop };
                }
                let (x, y) = (hop.position.x, hop.position.y);
                hop.position.z = ground.height_m(x, y);
                let (normal, soil) = (ground.normal(x, y), surface.soil(x, y));
                let rough = {
                    let lean = noise.lean(hop.impact_count, soil.roughness_rad);
                    let long = normal + lean;
                    long / libm::sqrt(long.norm_squared())
                };
                let before = [velocity, spin];
                [velocity, spin] = impact(body, soil, gravity_mps2, before, normal, rough);
                tell(&Impact {
                    position: hop.position,
                    before: before[0],
                    after: velocity,
                    spins: [before[1], spin],
                    seconds: hop.seconds,
                });
                hop.impact_count += 1;
                if velocity.dot(&normal) >= stop_mps {
                    break;
                }
                // It rolls without slipping, and gains nothing by that.
                let along = tangential(velocity, normal);
                let slip = tangential(along + spin.cross(&(normal * -body.radius_m)), normal);
                let rolled =
                    rolling.roll(surface, patch, hop.position, along - slip * body.sticking(), &mut arcs);
                hop.position = rolled.position;
                hop.rolled_m += rolled.metres;
                hop.seconds += rolled.seconds;
                velocity = rolled.velocity;
                match rolled.rest {
                    Rest::Rests => return hop,
                    Rest::Caught => return Ending { end: End::Caught, ..hop },
                    Rest::LeftMap => return Ending { end: End::LeftMap, ..hop },
                    Rest::RolledAway => return Ending { end: End::RolledAway, ..hop },
                    Rest::Bounces(next) => {
                        patch = next;
                        ground = surface.bilinear(patch);
                        let normal = ground.normal(hop.position.x, hop.position.y);
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
