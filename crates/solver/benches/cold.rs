//! Cold solves of seeded worlds: times, sweeps, certificates, and how close they come to the kernel's speed in cache.
//!
//! `cargo bench -p hopper-solver --bench cold [SIDE...]`. One thread. Each time is the median (and the least) of
//! solves by one solver, buffers kept. "Kernel" is what as many sweeps would take if each ran as fast as
//! on a world of 60 × 60, whose planes lie in the nearest caches, measured in the same run.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

use std::time::Instant;

use solver::fixtures::Fixture;
use solver::{Effort, GridWorld, Simd, Solver, certify};

/// Side of the world on which the kernel is timed.
const KERNEL_SIDE: usize = 60;

fn main() {
    // Cargo passes --bench along.
    let sides: Vec<usize> = std::env::args().skip(1).filter_map(|side| side.parse().ok()).collect();
    let sides = if sides.is_empty() { vec![20, 50, 200, 821] } else { sides };
    println!("vectors: {:?}\n", Simd::detect());
    println!(
        "| world | vectors | median [ms] | least [ms] | sweeps | residual passes | bound | kernel [ms] | ratio |\n\
         |---|---|---|---|---|---|---|---|---|"
    );
    for side in sides {
        for (name, fixture) in [
            ("plain", Fixture::plain(side, 1)),
            ("inner", Fixture::inner(side, 1)),
            ("trap", Fixture::trap(side, 1)),
        ] {
            let world = fixture.world().expect("a fixture of a sound size");
            for simd in
                [Simd::Avx512, Simd::Avx2, Simd::Portable].into_iter().filter(|simd| simd.is_available())
            {
                row(&format!("{name} {side}²"), &world, simd);
            }
        }
    }
    println!("\npeak resident memory, worlds and everything: {}", peak_memory());
}

fn row(name: &str, world: &GridWorld, simd: Simd) {
    let mut solver = Solver::with_simd(simd);
    let solution = solver.solve(world, &Effort::default());
    assert_eq!(solution.certificate, certify(world, solver.values()), "the certificate is the definition's");
    let rounds = (20_000_000 / world.nodes() / solution.sweeps as usize).clamp(5, 501);
    let [least, median] = time_ms(rounds, || {
        solver.solve(world, &Effort::default());
    });
    let kernel = sweep_ns(simd) * 1e-6 * (solution.sweeps * world.nodes() as u64) as f64;
    println!(
        "| {name} | {simd:?} | {median:.3} | {least:.3} | {} | {} | {:.1e} | {kernel:.3} | {:.2} |",
        solution.sweeps,
        solution.residual_passes,
        solution.certificate.error_bound,
        median / kernel
    );
}

/// Least and median time.
fn time_ms(rounds: usize, mut of: impl FnMut()) -> [f64; 2] {
    let mut times: Vec<f64> = (0..rounds)
        .map(|_| {
            let started = Instant::now();
            of();
            started.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    [times[0], times[rounds / 2]]
}

/// Nanoseconds a node for one sweep in cache: what 15 sweeps take longer than 5, over 10.
fn sweep_ns(simd: Simd) -> f64 {
    let world = Fixture::trap(KERNEL_SIDE, 1).world().expect("a fixture of a sound size");
    let mut solver = Solver::with_simd(simd);
    let mut least = |sweeps_max| {
        let effort = Effort { error_max: 0.0, sweeps_max };
        time_ms(301, || {
            solver.solve(&world, &effort);
        })[0]
    };
    (least(15) - least(5)) * 1e6 / (10 * world.nodes()) as f64
}

/// Peak resident memory of this process (`VmHWM`).
fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or_else(|| "unknown".into(), |line| line.trim().to_owned())
}
