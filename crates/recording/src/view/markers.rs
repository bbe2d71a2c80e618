//! Robots and goals as posts of points that stand out on any ground: bright and dark by turns.

use report::colour;

use super::point_cloud::{Cloud, Point};

/// Points of a post, and of the ring around its foot.
const POST_POINTS: u32 = 10;
const RING_POINTS: u32 = 12;

/// The dark that alternates with the colour of a marker.
const DARK: [u8; 3] = [0x11, 0x11, 0x11];

/// Adds a post of `height_m` on a ring at `foot`.
fn post(cloud: &mut Cloud, foot: Point, height_m: f64, colour: [u8; 3]) {
    for n in 0..POST_POINTS {
        let z = foot.z + height_m * f64::from(n) / f64::from(POST_POINTS - 1);
        cloud.push(Point { z, ..foot }, if n % 4 == 3 { DARK } else { colour });
    }
    for n in 0..RING_POINTS {
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(n) / f64::from(RING_POINTS));
        let radius_m = height_m / 5.0;
        let at = Point { x: foot.x + radius_m * cosine, y: foot.y + radius_m * sine, ..foot };
        cloud.push(at, if n % 2 == 0 { colour } else { DARK });
    }
}

/// Adds a robot.
pub(super) fn robot(cloud: &mut Cloud, at: Point, number: u16, height_m: f64) {
    post(cloud, at, height_m, colour::ROBOTS[usize::from(number) % colour::ROBOTS.len()]);
}

/// Adds a goal, twice as high as a robot.
pub(super) fn goal(cloud: &mut Cloud, at: Point, height_m: f64) {
    post(cloud, at, 2.0 * height_m, colour::rgb(colour::GOAL));
}
