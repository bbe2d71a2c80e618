//! How hops end on hostile ground, and whether any of them gains energy: as many hops as the argument says, 100,000 without one.
//!
//! Each ground of 16 × 16 cells is rough, stepped, saw-toothed, bumpy or flat, of two random soils, and sees 1,000 hops of random bodies
//! from random places. The total energy, that of the spin included, is compared from contact to contact.

#![allow(clippy::print_stdout, reason = "a benchmark reports on standard output")]

use std::process::ExitCode;

use contact::{Body, End, Ending, Field, Limits, Noise, Place, Soil, Surface};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::time::{ClockId, clock_gettime};

const SIDE: usize = 16;
const GRAVITY_MPS2: f64 = 3.72;
const HOPS_A_GROUND: u64 = 1_000;

/// Share of v² + g (|z| + extent of the map) by which rounding may raise the energy.
const GROWTH_MAX: f64 = 1e-12;

/// Numbers that are evenly distributed.
struct Chance(ChaCha8Rng);

impl Chance {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

struct Ground {
    cell_m: f64,
    heights_m: Vec<f64>,
    soils: [Soil; 2],
}

impl Ground {
    fn random(chance: &mut Chance) -> Self {
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
        Self { cell_m: chance.between(0.2, 3.0), heights_m, soils }
    }
}

impl Field for Ground {
    fn size(&self) -> [usize; 2] {
        [SIDE; 2]
    }

    fn cell_m(&self) -> f64 {
        self.cell_m
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        self.heights_m[row * SIDE + column]
    }

    fn soil(&self, column: usize, row: usize) -> &Soil {
        &self.soils[(column / 4 + row / 4) % 2]
    }
}

/// A hop of a random body; `None` if it does not leave the ground. With it the largest growth of energy between two contacts, as a
/// share of the scale that [`GROWTH_MAX`] is of.
fn hop(surface: &Surface<Ground>, chance: &mut Chance, number: u64) -> Option<(Ending, f64)> {
    let extent_m = SIDE as f64 * surface.cell_m();
    let body =
        Body { radius_m: chance.between(1e-3, 0.5) * surface.cell_m(), inertia: chance.between(0.05, 0.9) };
    let [x, y] = [(); 2].map(|()| chance.between(0.0, extent_m));
    let start = Vector3::new(x, y, surface.height_m(x, y));
    let velocity =
        Vector3::new(chance.between(-3.0, 3.0), chance.between(-3.0, 3.0), chance.between(-1.0, 4.0));
    let place = Place { surface, body: &body, gravity_mps2: GRAVITY_MPS2, hop_m: 1.0 };
    let launched = place.foothold(start, velocity)?;
    let scale = launched.norm_squared() + GRAVITY_MPS2 * (start.z.abs() + extent_m);
    let energy = |at: Vector3<f64>, velocity: Vector3<f64>, spin: Vector3<f64>| {
        let turning = body.inertia * body.radius_m * body.radius_m * spin.norm_squared();
        0.5 * (velocity.norm_squared() + turning) + GRAVITY_MPS2 * at.z
    };
    let mut last = energy(start, launched, Vector3::zeros());
    let mut growth = 0.0_f64;
    let noise = &mut Noise::new([9; 32], number);
    let ending = place.follow(start, launched, noise, &Limits::default(), |impact| {
        let before = energy(impact.position, impact.before, impact.spins[0]);
        let after = energy(impact.position, impact.after, impact.spins[1]);
        growth = growth.max(before - last).max(after - before);
        last = after;
    });
    if matches!(ending.end, End::Rest | End::Caught) {
        growth = growth.max(GRAVITY_MPS2 * ending.position.z - last);
    }
    Some((ending, growth / scale))
}

/// Processor time of this process so far, seconds.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
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
    let mut surface = Surface::new(Ground::random(chance));
    for number in 0..hops {
        if number % HOPS_A_GROUND == 0 {
            surface = Surface::new(Ground::random(chance));
        }
        let Some((ending, growth)) = hop(&surface, chance, number) else {
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
