//! How hops end on hostile ground, and whether any of them gains energy: as many hops as the argument says, 100,000 without one.
//!
//! Each ground of 16 × 16 cells is rough, stepped, saw-toothed, bumpy or flat, of two random soils, and sees 1,000 hops of random bodies
//! from random places. The total energy, that of the spin included, is compared from contact to contact.

#![allow(clippy::print_stdout, reason = "a benchmark reports on standard output")]

use std::process::ExitCode;

#[path = "clock/mod.rs"]
mod clock;
#[path = "../tests/hostile/mod.rs"]
mod hostile;

use contact::{Body, End, Noise, Soil, Surface};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use clock::processor_s;
use hostile::{Flown, GROWTH_MAX, Ground, SIDE};

const GRAVITY_MPS2: f64 = 3.72;
const HOPS_A_GROUND: u64 = 1_000;

/// Numbers that are evenly distributed.
struct Chance(ChaCha8Rng);

impl Chance {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// Ground of any shape and soils.
fn ground(chance: &mut Chance) -> Ground {
    let shape = chance.between(0.0, 5.0) as u32;
    let tooth_m = chance.between(0.1, 2.0);
    let mut height_m = |index: usize| match shape {
        0 => chance.between(-1.0, 1.0),
        1 => [0.0, 1.0, -2.0][chance.between(0.0, 3.0) as usize],
        2 => tooth_m * (index % 2) as f64,
        3 => chance.between(-0.1, 0.1),
        _ => 0.0,
    };
    let heights_m = (0..SIDE * SIDE).map(&mut height_m).collect();
    let mut soil = || Soil {
        restitution: chance.between(0.0, 1.0),
        restitution_speed_mps: f64::INFINITY,
        restitution_gravity_mps2: f64::INFINITY,
        friction: chance.between(0.0, 2.0),
        rolling: chance.between(1e-3, 2.0),
        foot: chance.between(0.0, 2.0),
        roughness_rad: chance.between(0.0, 0.3),
    };
    let soils = [soil(), soil()];
    Ground { cell_m: chance.between(0.2, 3.0), heights_m, soils }
}

/// A hop of a random body from a random place; `None` if it does not leave the ground.
fn hop(surface: &Surface<Ground>, chance: &mut Chance, number: u64) -> Option<Flown> {
    let extent_m = SIDE as f64 * surface.cell_m();
    let body =
        Body { radius_m: chance.between(1e-3, 0.5) * surface.cell_m(), inertia: chance.between(0.05, 0.9) };
    let from = [(); 2].map(|()| chance.between(0.0, extent_m));
    let velocity = [chance.between(-3.0, 3.0), chance.between(-3.0, 3.0), chance.between(-1.0, 4.0)];
    hostile::fly(surface, &body, GRAVITY_MPS2, from, velocity, &mut Noise::new([9; 32], number))
}

fn main() -> ExitCode {
    let hops = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(100_000_u64);
    const ENDS: [(End, &str); 6] = [
        (End::Rest, "rest"),
        (End::Caught, "caught in a crease or pit"),
        (End::NoLaunch, "did not leave the ground"),
        (End::LeftMap, "left the map"),
        (End::RolledAway, "rolled away"),
        (End::BouncedOn, "impacts exhausted"),
    ];
    let mut counts = [0_u64; 6];
    let (mut impacts, mut impacts_most, mut growth_most, mut grew) = (0_u64, 0, 0.0_f64, 0_u64);
    let chance = &mut Chance(ChaCha8Rng::seed_from_u64(1));
    let mut surface = Surface::new(ground(chance));
    for number in 0..hops {
        if number % HOPS_A_GROUND == 0 {
            surface = Surface::new(ground(chance));
        }
        let Some(Flown { ending, growth }) = hop(&surface, chance, number) else {
            counts[2] += 1;
            continue;
        };
        counts[ENDS.iter().position(|(end, _)| *end == ending.end).expect("every end is listed")] += 1;
        impacts += u64::from(ending.impact_count);
        impacts_most = impacts_most.max(ending.impact_count);
        growth_most = growth_most.max(growth);
        grew += u64::from(growth > GROWTH_MAX);
    }
    for ((_, name), count) in ENDS.iter().zip(counts) {
        println!("{name}: {count} ({:.4} %)", 100.0 * count as f64 / hops as f64);
    }
    println!("impacts: {impacts}, at most {impacts_most} a hop");
    println!(
        "largest growth of energy: {growth_most:.1e} of v² + g (|z| + extent); beyond {GROWTH_MAX:.0e}: {grew} hops"
    );
    println!("processor time: {:.0} s for {hops} hops", processor_s());
    if grew == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
