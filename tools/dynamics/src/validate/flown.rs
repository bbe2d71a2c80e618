//! What has flown, and what will.

use contact::{Body, Hop, Noise, Place, Plane, Surface};
use contract::Soil;
use nalgebra::Vector3;
use scenario::Preset;

use super::{Row, central};
use crate::hopper_on::soil_of;

/// Landings that are flown for each row.
const LANDINGS: u64 = 4_000;

/// Landings of a body that comes down at a speed, m/s, up to so many degrees off the vertical, on level ground.
fn landings(preset: Preset, kind: Soil, body: &Body, speed_mps: [f64; 2], off_deg: f64) -> Vec<(f64, Hop)> {
    // Wide enough for the longest bounce.
    let plane = Plane::new(100.0, [0.0; 2], soil_of(preset, kind));
    let middle_m = plane.middle_m();
    let surface = Surface::new(plane);
    let place = Place { surface: &surface, body, gravity_mps2: preset.gravity_mps2(), hop_m: 1.0 };
    let from = Vector3::new(middle_m, middle_m, 0.0);
    let landing = |number: u64| {
        let share = |prime: f64| (number as f64 * prime).fract();
        let off = (off_deg * share(0.618_033_988_749_894_9)).to_radians();
        let speed_mps = speed_mps[0] + (speed_mps[1] - speed_mps[0]) * share(0.414_213_562_373_095);
        let velocity = Vector3::new(libm::sin(off), 0.0, -libm::cos(off)) * speed_mps;
        let hop = place.hop(from, velocity, &mut Noise::new([2; 32], number));
        ((hop.position - from).norm(), hop)
    };
    (0..LANDINGS).map(landing).collect()
}

/// MASCOT: a box of 0.3 m, which came down 41 m within 351 s.
fn mascot() -> Vec<Row> {
    const SCHOLTEN: &str = "Scholten et al. 2019, A&A 632, L3 (abstract)";
    let gravity_mps2 = Preset::Ryugu.gravity_mps2();
    let arrives_mps = 41.0 / 351.0 + gravity_mps2 * 351.0 / 2.0;
    let body = Body { radius_m: 0.15, inertia: 0.4 };
    let flown = landings(Preset::Ryugu, Soil::Hard, &body, [arrives_mps; 2], 20.0);
    let contacts = |hop: &Hop| f64::from(hop.impact_count);
    let mut seconds: Vec<f64> = flown.iter().map(|(_, hop)| hop.seconds).collect();
    let mut metres: Vec<f64> = flown.iter().map(|(metres, _)| *metres).collect();
    // The first and the last are not among the four between them.
    let mut between: Vec<f64> = flown.iter().map(|(_, hop)| contacts(hop) - 2.0).collect();
    let is_all = |(metres, hop): &&(f64, Hop)| {
        (hop.seconds / 663.0 - 1.0).abs() < 0.1 && (metres / 17.0 - 1.0).abs() < 0.1 && contacts(hop) == 6.0
    };
    let all = flown.iter().filter(is_all).count() as f64 / LANDINGS as f64;
    let row = |source, quantity, published: &str, values: &mut [f64], value: f64, unit: &str| {
        let ([low, high], holds) = central(values, value);
        Row::new(source, quantity, published).is(format!("{low:.0} to {high:.0}{unit} (90 %)"), holds)
    };
    vec![
        row(SCHOLTEN, "MASCOT on Ryugu: bouncing", "663 s", &mut seconds, 663.0, " s"),
        row(SCHOLTEN, "MASCOT: contacts between the first and rest", "4", &mut between, 4.0, ""),
        row(
            "DLR 2019, MASCOT's 17 hours",
            "MASCOT: way from first contact to rest",
            "17 m",
            &mut metres,
            17.0,
            " m",
        ),
        Row::new(SCHOLTEN, "MASCOT: all three within a tenth, at once", "it happened")
            .is(format!("{:.1} % of landings", 100.0 * all), all >= 0.05),
    ]
}

/// IDEFIX: a rover of 25 kg that will be dropped from 40 to 100 m above Phobos. Frozen on 2026-11-26.
fn idefix() -> Vec<Row> {
    const MMX: &str = "MMX, IDEFIX (to be flown)";
    let gravity_mps2 = Preset::Phobos.gravity_mps2();
    let arrives_mps = [40.0, 100.0].map(|metres: f64| libm::sqrt(2.0 * gravity_mps2 * metres));
    let body = Body { radius_m: 0.22, inertia: 0.4 };
    let flown = landings(Preset::Phobos, Soil::Sand, &body, arrives_mps, 20.0);
    let mut seconds: Vec<f64> = flown.iter().map(|(_, hop)| hop.seconds).collect();
    let mut metres: Vec<f64> = flown.iter().map(|(metres, _)| *metres).collect();
    let mut contacts: Vec<f64> = flown.iter().map(|(_, hop)| f64::from(hop.impact_count)).collect();
    let interval = |values: &mut [f64], unit: &str| {
        let ([low, high], _) = central(values, 0.0);
        format!("{low:.1} to {high:.1}{unit} (90 %)")
    };
    vec![
        Row::new(MMX, "IDEFIX on Phobos: speed of touchdown from 40 to 100 m", "below 1 m/s")
            .is(format!("{:.2} to {:.2} m/s", arrives_mps[0], arrives_mps[1]), arrives_mps[1] < 1.0),
        Row::new(MMX, "IDEFIX: contacts, predicted 2026-11-26", "–").left_open(interval(&mut contacts, "")),
        Row::new(MMX, "IDEFIX: bouncing, predicted 2026-11-26", "–").left_open(interval(&mut seconds, " s")),
        Row::new(MMX, "IDEFIX: way to rest, predicted 2026-11-26", "–")
            .left_open(interval(&mut metres, " m")),
    ]
}

/// The rows.
pub fn rows() -> Vec<Row> {
    let restitution = 0.325 / 1.01;
    let philae =
        Row::new("Biele et al. 2015, Science 349", "Philae at Agilkia: speeds in and out", "1.01, 0.325 m/s")
            .left_open(format!("a fit: e = {restitution:.2}"));
    let sinks = Row::new(
        "Walsh et al. 2022, Sci. Adv. 8",
        "OSIRIS-REx on Bennu: the arm sank at 10 cm/s",
        "about 0.5 m",
    )
    .is("0 m: contact points lie on the ground", false);
    mascot().into_iter().chain([philae, sinks]).chain(idefix()).collect()
}
