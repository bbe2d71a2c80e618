//! Hops whose outcome has a closed form, to 1e-9.

use contact::{Body, End, Hop, Noise, Place, Plane, Soil, Surface};
use nalgebra::Vector3;

use super::Row;

const SOURCE: &str = "closed form";
const GRAVITY_MPS2: f64 = 3.72;
const SOLID: Body = Body { radius_m: 0.1, inertia: 0.4 };
const SMOOTH: Soil = Soil {
    restitution: 0.5,
    restitution_speed_mps: f64::INFINITY,
    restitution_gravity_mps2: f64::INFINITY,
    friction: 0.0,
    rolling: 1e9,
    foot: 1e9,
    roughness_rad: 0.0,
};

/// A hop from the middle of a plane.
fn hop(slope: f64, soil: Soil, velocity: [f64; 3]) -> (Vector3<f64>, Hop) {
    let plane = Plane::new(1.0, [slope, 0.0], soil);
    let middle_m = plane.middle_m();
    let surface = Surface::new(plane);
    let place = Place { surface: &surface, body: &SOLID, gravity_mps2: GRAVITY_MPS2, hop_m: 1.0 };
    let from = Vector3::new(middle_m, middle_m, surface.height_m(middle_m, middle_m));
    (from, place.hop(from, velocity.into(), &mut Noise::none()))
}

fn number(quantity: &'static str, need: f64, got: f64, unit: &str) -> Row {
    let holds = (got - need).abs() <= 1e-9 * need.abs().max(1.0);
    Row::new(SOURCE, quantity, format!("{need:.9} {unit}")).is(format!("{got:.9} {unit}"), holds)
}

/// The rows.
pub fn rows() -> Vec<Row> {
    let side = 2.0_f64.sqrt();
    let dead = Soil { restitution: 0.0, friction: 1e9, ..SMOOTH };
    let (from, flat) = hop(0.0, dead, [side, 0.0, side]);
    let (up_from, up) = hop(0.2, dead, [side, 0.0, side]);
    let up_s = 2.0 * (side - 0.2 * side) / GRAVITY_MPS2;
    let (_, bouncing) = hop(0.0, SMOOTH, [side, 0.0, side]);
    let rolling = Soil { rolling: 0.1, ..dead };
    let (_, rolled) = hop(0.0, rolling, [1.0, 0.0, 1e-9]);
    let rests = |slope: f64| hop(slope, rolling, [0.0, 0.0, 0.5]).1.end == End::Rest;
    let limits = [rests(0.0999), !rests(0.1001)];
    let angle = (if limits == [true, true] { "rests at .0999, not at .1001" } else { "another" }).to_string();
    vec![
        number(
            "range on the flat, 2 m/s at 45°",
            4.0 / GRAVITY_MPS2,
            flat.impacts[0].position.x - from.x,
            "m",
        ),
        number("time of that flight", 2.0 * side / GRAVITY_MPS2, flat.impacts[0].seconds, "s"),
        number("range up a slope of .2", side * up_s, up.impacts[0].position.x - up_from.x, "m"),
        Row::new(SOURCE, "contacts of a frictionless bounce with e = .5", "5")
            .is(bouncing.impact_count.to_string(), bouncing.impact_count == 5),
        Row::new(SOURCE, "time of that bounce", "1.473139 s").is(
            format!("{:.6} s", bouncing.impacts[4].seconds),
            (bouncing.impacts[4].seconds - 1.473_139).abs() < 1e-6,
        ),
        number("speed kept by a solid sphere that sticks", 5.0 / 7.0, rolled.impacts[0].after.x, "m/s"),
        Row::new(SOURCE, "way rolled from 1 m/s with c = .1", "0.960061 m")
            .is(format!("{:.6} m", rolled.rolled_m), (rolled.rolled_m - 0.960_061).abs() < 1e-6),
        Row::new(SOURCE, "tangent of the steepest slope that holds, c = .1", "0.1")
            .is(angle, limits == [true, true]),
    ]
}
