//! Valleys, in whose crease gravity turns a rolling body back from either side.

use contact::{Body, End, Field, Hop, Noise, Place, Soil, Surface};
use nalgebra::Vector3;

const SIDE: usize = 40;
const BODY: Body = Body { radius_m: 0.1, inertia: 0.4 };
/// Neither rebounds nor slides, and rests up to a slope of .1.
const SOIL: Soil = Soil { restitution: 0.0, friction: 1e9, rolling: 0.1, roughness_rad: 0.0, ..Soil::HARD };

/// Two walls of a slope that meet in a crease along y, at x = 20.5, which rises northwards.
struct Valley {
    wall: f64,
    rise: f64,
}

impl Field for Valley {
    fn size(&self) -> [usize; 2] {
        [SIDE; 2]
    }

    fn cell_m(&self) -> f64 {
        1.0
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        self.wall * (column as f64 - 20.0).abs() + self.rise * row as f64
    }

    fn soil(&self, _: usize, _: usize) -> &Soil {
        &SOIL
    }
}

fn hop(valley: Valley, [x, y]: [f64; 2], velocity: [f64; 3]) -> Hop {
    let surface = Surface::new(valley);
    let place = Place { surface: &surface, body: &BODY, gravity_mps2: 3.72, hop_m: 1.0 };
    place.hop(Vector3::new(x, y, surface.height_m(x, y)), velocity.into(), &mut Noise::none())
}

/// P-CONTACT-VALLEY: A valley holds a body that its walls do not hold, and one that falls leads it down: neither loses it.
#[test]
fn a_level_valley_holds_a_body_that_its_walls_do_not_hold() {
    for x in [20.3, 20.5, 20.7, 21.5, 22.3] {
        for speed_mps in [0.0, 0.1, 0.3] {
            let hop = hop(Valley { wall: 0.3, rise: 0.0 }, [x, 20.1], [speed_mps, 0.1, 0.2]);
            assert!(matches!(hop.end, End::Rest | End::Caught), "{x} {speed_mps}: {hop:?}");
            assert!((hop.position.x - 20.5).abs() < 0.1, "{x} {speed_mps}: {hop:?}");
        }
    }
}

/// P-CONTACT-VALLEY.
#[test]
fn a_body_follows_a_valley_that_falls_more_than_it_rests_on() {
    for x in [20.3, 20.45, 20.6, 21.5] {
        let hop = hop(Valley { wall: 0.3, rise: 0.15 }, [x, 20.1], [0.02, -0.2, 0.2]);
        assert_eq!(hop.end, End::LeftMap, "{x}: {hop:?}");
        assert!(hop.position.y < 0.01 && (hop.position.x - 20.5).abs() < 0.5, "{x}: {hop:?}");
    }
}
