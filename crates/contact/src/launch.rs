//! The launch: its speed as trimmed by launch control, its errors, and what the foot holds.

use nalgebra::Vector3;

use crate::body::Body;
use crate::bounds::{TRIM_ARCS_MAX, TRIM_EVALUATIONS, TRIM_IMPACTS_MAX, TRIM_TOLERANCE};
use crate::hop::{End, Limits, Place};
use crate::noise::Noise;
use crate::plane::Plane;
use crate::soil::Soil;
use crate::surface::Surface;

/// What launch control aims at.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// Towards the target: (east, north), metres from the body.
    pub target_m: [f64; 2],
    /// Elevation above the horizontal, radians.
    pub elevation_rad: f64,
    /// Largest speed, m/s.
    pub speed_max_mps: f64,
}

/// Standard deviations of a launch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaunchErrors {
    /// Of the speed, as a share of it.
    pub speed: f64,
    /// Of the azimuth, radians.
    pub azimuth_rad: f64,
    /// Of the elevation, radians.
    pub elevation_rad: f64,
}

/// What launch control knows of the ground: a plane of one soil.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// (∂h/∂x, ∂h/∂y) where the body stands.
    pub gradient: [f64; 2],
    /// The soil there, as it is believed to be.
    pub soil: Soil,
}

impl Aim {
    fn distance_m(&self) -> f64 {
        let [east, north] = self.target_m;
        libm::sqrt(east * east + north * north)
    }

    /// The direction of a launch that is turned by so much, of length 1.
    fn direction(&self, azimuth_rad: f64, elevation_rad: f64) -> Vector3<f64> {
        let [east, north] = self.target_m;
        let azimuth = libm::atan2(north, east) + azimuth_rad;
        let elevation = self.elevation_rad + elevation_rad;
        let level = libm::cos(elevation);
        Vector3::new(level * libm::cos(azimuth), level * libm::sin(azimuth), libm::sin(elevation))
    }

    /// The speed at which a hop without errors, on a plane without roughness, comes to rest at the target's distance, measured along
    /// the aim; the largest speed where none does. On ground too steep to rest on, that of the first contact.
    ///
    /// Any end but rest counts as too far. The root of distance over v² is found by the Illinois method, between 0 and the largest speed,
    /// with at most [`TRIM_EVALUATIONS`] hops.
    #[must_use]
    pub fn trimmed_mps(&self, body: &Body, gravity_mps2: f64, known: &Known) -> f64 {
        if self.distance_m() == 0.0 {
            return 0.0;
        }
        self.over(body, gravity_mps2, known, |miss_m| self.root_mps(miss_m))
    }

    /// Whether a hop without errors at the largest speed comes as far as the target on such a plane.
    #[must_use]
    pub fn is_reached(&self, body: &Body, gravity_mps2: f64, known: &Known) -> bool {
        let distance_m = self.distance_m();
        let most = self.speed_max_mps * self.speed_max_mps;
        distance_m == 0.0
            || self.over(body, gravity_mps2, known, |miss_m| miss_m(most) >= -TRIM_TOLERANCE * distance_m)
    }

    /// What `ask` makes of how much too far a hop at a squared speed ends, metres, on a plane without roughness.
    fn over<A>(
        &self,
        body: &Body,
        gravity_mps2: f64,
        known: &Known,
        ask: impl FnOnce(&dyn Fn(f64) -> f64) -> A,
    ) -> A {
        let distance_m = self.distance_m();
        let smooth = Soil { roughness_rad: 0.0, ..known.soil };
        let plane = Plane::new(distance_m, known.gradient, smooth);
        let middle_m = plane.middle_m();
        let surface = Surface::new(plane);
        let place = Place { surface: &surface, body, gravity_mps2, hop_m: distance_m };
        let [east, north] = self.target_m.map(|metres| metres / distance_m);
        let steep = libm::hypot(known.gradient[0], known.gradient[1]);
        let limits = Limits {
            impacts: TRIM_IMPACTS_MAX,
            arcs: TRIM_ARCS_MAX,
            to_first_contact: steep > smooth.rolling,
        };
        let from = Vector3::new(middle_m, middle_m, surface.height_m(middle_m, middle_m));
        let direction = self.direction(0.0, 0.0);
        ask(&|squared: f64| {
            let launch = direction * libm::sqrt(squared);
            let Some(launched) = place.foothold(from, launch) else { return -distance_m };
            let hop = place.follow(from, launched, &mut Noise::none(), &limits, |_| {});
            match hop.end {
                End::Rest | End::Caught => {
                    let gone = hop.position - from;
                    gone.x * east + gone.y * north - distance_m
                }
                _ => distance_m,
            }
        })
    }

    /// The speed at which a hop misses least, m/s.
    fn root_mps(&self, miss_m: &dyn Fn(f64) -> f64) -> f64 {
        let distance_m = self.distance_m();
        let most = self.speed_max_mps * self.speed_max_mps;
        let (mut low, mut low_miss) = (0.0, -distance_m);
        let (mut high, mut high_miss) = (most, miss_m(most));
        if high_miss <= 0.0 {
            return self.speed_max_mps;
        }
        let mut best = (high_miss, most);
        for _ in 1..TRIM_EVALUATIONS {
            let middle = (low * high_miss - high * low_miss) / (high_miss - low_miss);
            let miss = miss_m(middle);
            if libm::fabs(miss) < libm::fabs(best.0) {
                best = (miss, middle);
            }
            if libm::fabs(miss) <= TRIM_TOLERANCE * distance_m {
                break;
            }
            // The end that stays counts half, so that both close in.
            if miss > 0.0 {
                (high, high_miss, low_miss) = (middle, miss, 0.5 * low_miss);
            } else {
                (low, low_miss, high_miss) = (middle, miss, 0.5 * high_miss);
            }
        }
        libm::sqrt(best.1)
    }

    /// The launch at a trimmed speed with its errors, which take the numbers 0 to 2 of `noise`.
    #[must_use]
    pub fn launch(&self, trimmed_mps: f64, errors: &LaunchErrors, noise: &mut Noise) -> Vector3<f64> {
        let [speed, azimuth, elevation] = [0, 1, 2].map(|index| noise.normal(index));
        let speed_mps = (trimmed_mps * (1.0 + errors.speed * speed)).max(0.0);
        self.direction(errors.azimuth_rad * azimuth, errors.elevation_rad * elevation) * speed_mps
    }
}
