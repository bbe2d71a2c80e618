//! Hops whose outcome has a closed form.

use contact::{Body, End, Field, Noise, Place, Soil, Surface};
use nalgebra::Vector3;

const MARS_MPS2: f64 = 3.72;
const SOLID: Body = Body { radius_m: 0.1, inertia: 0.4 };
const SMOOTH: Soil = Soil {
    restitution: 0.5,
    restitution_speed_mps: f64::INFINITY,
    restitution_gravity_mps2: f64::INFINITY,
    friction: 0.0,
    rolling: 0.1,
    foot: 10.0,
    roughness_rad: 0.0,
};

/// Ground of 40 × 40 cells of a metre, of one soil.
struct Ground {
    heights_m: Vec<f64>,
    soil: Soil,
}

impl Field for Ground {
    fn size(&self) -> [usize; 2] {
        [40; 2]
    }

    fn cell_m(&self) -> f64 {
        1.0
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        self.heights_m[row * 40 + column]
    }

    fn soil(&self, _: usize, _: usize) -> &Soil {
        &self.soil
    }
}

/// Ground that rises by `slope` eastwards.
fn plane(slope: f64, soil: Soil) -> Surface<Ground> {
    let heights_m = (0..40 * 40).map(|index| slope * (f64::from(index % 40) + 0.5)).collect();
    Surface::new(Ground { heights_m, soil })
}

fn place(surface: &Surface<Ground>) -> Place<'_, Ground> {
    Place { surface, body: &SOLID, gravity_mps2: MARS_MPS2, hop_m: 1.0 }
}

fn on(surface: &Surface<Ground>, x: f64, y: f64) -> Vector3<f64> {
    Vector3::new(x, y, surface.height_m(x, y))
}

fn is_near(got: f64, need: f64) -> bool {
    (got - need).abs() <= 1e-9 * need.abs().max(1.0)
}

#[test]
fn range_and_time_are_those_of_a_parabola_on_flat_and_inclined_ground() {
    let dead = Soil { restitution: 0.0, friction: 10.0, rolling: 1e6, ..SMOOTH };
    for slope in [0.0, 0.2, -0.3] {
        let surface = plane(slope, dead);
        let speed = 2.0_f64;
        for (azimuth, elevation) in [(0.0_f64, 0.8_f64), (0.3, 1.1), (2.0, 0.9), (-2.5, 1.4)] {
            let velocity = Vector3::new(
                speed * elevation.cos() * azimuth.cos(),
                speed * elevation.cos() * azimuth.sin(),
                speed * elevation.sin(),
            );
            let from = on(&surface, 20.5, 20.5);
            let hop = place(&surface).hop(from, velocity, &mut Noise::none());
            let seconds = 2.0 * (velocity.z - slope * velocity.x) / MARS_MPS2;
            let first = hop.impacts[0];
            assert!(is_near(first.seconds, seconds), "{slope} {azimuth}: {} {seconds}", first.seconds);
            assert!(is_near(first.position.x, from.x + velocity.x * seconds), "{slope} {azimuth}");
            assert!(is_near(first.position.y, from.y + velocity.y * seconds), "{slope} {azimuth}");
        }
    }
}

#[test]
fn it_bounces_as_often_and_as_long_as_the_geometric_series_says() {
    let surface = plane(0.0, Soil { rolling: 1e9, ..SMOOTH });
    let side = 2.0 / 2.0_f64.sqrt();
    let hop =
        place(&surface).hop(on(&surface, 10.5, 10.5), Vector3::new(side, 0.0, side), &mut Noise::none());
    assert_eq!((hop.end, hop.impact_count), (End::Rest, 5));
    assert!((hop.impacts[4].seconds - 1.473_139).abs() < 1e-6, "{}", hop.impacts[4].seconds);
}

#[test]
fn what_sticks_keeps_five_sevenths_of_its_speed_and_rolls_as_far_as_its_energy_takes_it() {
    let surface = plane(0.0, Soil { restitution: 0.0, friction: 1e9, ..SMOOTH });
    // A hop of next to no height.
    let hop = place(&surface).hop(on(&surface, 10.5, 10.5), Vector3::new(1.0, 0.0, 1e-9), &mut Noise::none());
    let after = hop.impacts[0].after;
    assert!(is_near(after.x, 5.0 / 7.0), "{after:?}");
    assert_eq!(hop.end, End::Rest);
    let way_m = (5.0_f64 / 7.0).powi(2) * 1.4 / (2.0 * MARS_MPS2 * 0.1);
    assert!(is_near(hop.rolled_m, way_m), "{} {way_m}", hop.rolled_m);
}

#[test]
fn it_rests_up_to_the_slope_that_holds_it_and_rolls_away_beyond() {
    for (slope, rests) in [(0.09, true), (0.0999, true), (0.1001, false), (0.3, false)] {
        let surface = plane(slope, Soil { restitution: 0.0, friction: 1e9, ..SMOOTH });
        let hop =
            place(&surface).hop(on(&surface, 30.5, 10.5), Vector3::new(0.0, 0.0, 0.5), &mut Noise::none());
        let end = if rests { End::Rest } else { End::LeftMap };
        assert_eq!(hop.end, end, "{slope}: {hop:?}");
    }
}

#[test]
fn a_wall_stops_a_hop_that_a_table_would_let_pass() {
    let soil = Soil { restitution: 0.0, friction: 0.6, rolling: 0.6, ..SMOOTH };
    let heights_m = (0..40 * 40).map(|index| if index % 40 >= 12 { 1.0 } else { 0.0 }).collect();
    let surface = Surface::new(Ground { heights_m, soil });
    // 45°, .93 m: its apex is at .23 m.
    let side = (MARS_MPS2 / 2.0).sqrt();
    let hop =
        place(&surface).hop(on(&surface, 11.0, 10.5), Vector3::new(side, 0.0, side), &mut Noise::none());
    assert!(hop.position.z < 0.3 && hop.position.x < 12.0, "{hop:?}");
}
