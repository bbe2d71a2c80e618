//! Bounces a second on rough ground, and whole hops a second, their trim included. Seconds are of processor time, so that what else
//! runs on the machine counts little.

#![allow(clippy::print_stdout, reason = "a benchmark reports on standard output")]

#[path = "clock/mod.rs"]
mod clock;

use contact::{Aim, Body, Field, Known, LaunchErrors, Noise, Place, Soil, Surface};
use nalgebra::Vector3;

use clock::processor_s;

const SIDE: usize = 128;

/// Ground of 128 × 128 cells of a metre, rough by some decimetres.
struct Rough {
    heights_m: Vec<f64>,
    soil: Soil,
}

impl Field for Rough {
    fn size(&self) -> [usize; 2] {
        [SIDE; 2]
    }

    fn cell_m(&self) -> f64 {
        1.0
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        self.heights_m[row * SIDE + column]
    }

    fn soil(&self, _: usize, _: usize) -> &Soil {
        &self.soil
    }
}

fn rough(soil: Soil) -> Surface<Rough> {
    let mut noise = Noise::new([3; 32], 0);
    let heights_m = (0..SIDE * SIDE).map(|index| 0.1 * noise.normal(index as u64)).collect();
    Surface::new(Rough { heights_m, soil })
}

fn main() {
    let body = Body { radius_m: 0.1, inertia: 0.4 };
    let gravity_mps2 = 3.72;
    // Elastic enough to bounce often, as the bounces of a hop are what is counted.
    let surface = rough(Soil { restitution: 0.8, ..Soil::HARD });
    let place = Place { surface: &surface, body: &body, gravity_mps2, hop_m: 1.0 };
    let (mut bounces, mut hops) = (0_u64, 0_u64);
    let started = processor_s();
    while processor_s() - started < 2.0 {
        for _ in 0..1_000 {
            let noise = &mut Noise::new([5; 32], hops);
            let start = Vector3::new(64.0, 64.0, surface.height_m(64.0, 64.0));
            let hop = place.hop(start, Vector3::new(1.3, 0.2, 1.4), noise);
            (bounces, hops) = (bounces + u64::from(hop.impact_count), hops + 1);
        }
    }
    let seconds = processor_s() - started;
    println!(
        "bounces a second: {:.2e} ({:.1} a hop)",
        bounces as f64 / seconds,
        bounces as f64 / hops as f64
    );

    let surface = rough(Soil::HARD);
    let place = Place { surface: &surface, body: &body, gravity_mps2, hop_m: 1.0 };
    let aim = Aim { target_m: [1.0, 0.1], elevation_rad: std::f64::consts::FRAC_PI_4, speed_max_mps: 2.6 };
    let errors = LaunchErrors { speed: 0.1, azimuth_rad: 0.15, elevation_rad: 0.03 };
    for (name, trims) in [("whole hops", true), ("hops without their trim", false)] {
        let mut hops = 0_u64;
        let started = processor_s();
        while processor_s() - started < 2.0 {
            for _ in 0..1_000 {
                let noise = &mut Noise::new([5; 32], hops);
                let (x, y) = (20.0 + (hops % 80) as f64, 20.0 + (hops / 80 % 80) as f64);
                let start = Vector3::new(x, y, surface.height_m(x, y));
                let normal = surface.normal(x, y);
                let known =
                    Known { gradient: [-normal.x / normal.z, -normal.y / normal.z], soil: Soil::HARD };
                let speed_mps = if trims { aim.trimmed_mps(&body, gravity_mps2, &known) } else { 1.9 };
                if let Some(held) = place.foothold(start, aim.launch(speed_mps, &errors, noise)) {
                    std::hint::black_box(place.hop(start, held, noise));
                }
                hops += 1;
            }
        }
        println!("{name} a second: {:.2e}", hops as f64 / (processor_s() - started));
    }
}
