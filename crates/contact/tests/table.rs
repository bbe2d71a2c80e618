//! Hops of a metre on inclined planes on Mars, beside the table of an independent program on the same model.

use contact::{Aim, Body, Known, LaunchErrors, Noise, Place, Plane, Soil, Surface};
use nalgebra::Vector3;

const HOPS: u64 = 4_000;

/// Shares of hops that rest on the cell aimed at, on that of departure, and elsewhere, and how far downhill they rest on average, metres.
fn shares(soil: Soil, along_deg: f64, across_deg: f64) -> ([f64; 3], f64) {
    let gradient = [along_deg.to_radians().tan(), across_deg.to_radians().tan()];
    let plane = Plane::new(1.0, gradient, soil);
    let middle_m = plane.middle_m();
    let surface = Surface::new(plane);
    let body = Body { radius_m: 0.1, inertia: 0.4 };
    let gravity_mps2 = 3.72;
    let place = Place { surface: &surface, body: &body, gravity_mps2, hop_m: 1.0 };
    let from = Vector3::new(middle_m, middle_m, surface.height_m(middle_m, middle_m));
    let aim = Aim { target_m: [1.0, 0.0], elevation_rad: std::f64::consts::FRAC_PI_4, speed_max_mps: 2.6 };
    let trimmed_mps = aim.trimmed_mps(&body, gravity_mps2, &Known { gradient, soil });
    let errors = LaunchErrors { speed: 0.1, azimuth_rad: 0.15, elevation_rad: 0.03 };
    let (mut counts, mut downhill_m) = ([0_u32; 3], 0.0);
    for number in 0..HOPS {
        let noise = &mut Noise::new([7; 32], number);
        let launch = aim.launch(trimmed_mps, &errors, noise);
        let rest = place.foothold(from, launch).map_or(from, |held| place.hop(from, held, noise).position);
        let [x, y] = [rest.x - from.x, rest.y - from.y].map(|metres| (metres + 0.5).floor() as i32);
        counts[match (x, y) {
            (1, 0) => 0,
            (0, 0) => 1,
            _ => 2,
        }] += 1;
        downhill_m -= rest.y - from.y;
    }
    (counts.map(|count| f64::from(count) / HOPS as f64), downhill_m / HOPS as f64)
}

/// P-CONTACT-TABLE: On planes, hops rest as often where they are aimed, where they started and elsewhere as an independent program says.
#[test]
fn hops_on_planes_rest_as_an_independent_program_says() {
    let mut wrong = Vec::new();
    for (name, along, across, hard, sand) in [
        ("flat", 0.0, 0.0, [0.98, 0.0, 0.02], [0.98, 0.0, 0.02]),
        ("up 10°", 10.0, 0.0, [0.97, 0.01, 0.03], [0.87, 0.13, 0.0]),
        ("up 15°", 15.0, 0.0, [0.94, 0.01, 0.05], [0.12, 0.88, 0.0]),
        ("up 20°", 20.0, 0.0, [0.70, 0.30, 0.01], [0.0, 1.0, 0.0]),
        ("up 25°", 25.0, 0.0, [0.02, 0.98, 0.0], [0.0, 1.0, 0.0]),
        ("down 20°", -20.0, 0.0, [0.92, 0.01, 0.06], [0.98, 0.0, 0.01]),
        ("across 10°", 0.0, 10.0, [0.93, 0.01, 0.07], [0.95, 0.0, 0.05]),
        ("across 20°", 0.0, 20.0, [0.54, 0.01, 0.44], [0.64, 0.01, 0.35]),
    ] {
        for (soil, word, need) in [(Soil::HARD, "hard", hard), (Soil::SAND, "sand", sand)] {
            let (got, downhill_m) = shares(soil, along, across);
            println!("{word} {name}: {got:.3?} {need:?} {downhill_m:.2} m downhill");
            // Rounded to hundredths there, and three standard errors here.
            let far = |(got, need): (f64, f64)| {
                (got - need).abs()
                    > 0.01 + 3.0 * (need.max(0.01) * (1.0 - need.min(0.99)) / HOPS as f64).sqrt()
            };
            if got.into_iter().zip(need).any(far) {
                wrong.push(format!("{word} {name}: {got:.3?}, needs {need:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
