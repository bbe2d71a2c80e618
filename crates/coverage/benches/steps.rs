//! Rover steps per second of the engines: deciding, driving, sensing, counting.
//!
//! `cargo bench -p hopper-coverage --bench steps`. One thread. Each figure is that of the median of rounds over the same worlds,
//! which are made beforehand; the best round is beside it. Time is the thread's processor time, so that other load on the
//! machine counts less.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

use contract::Grid;
use coverage::{Algorithm, CoverMode};
use coverage_world::{Mission, Setup, World};
use rustix::time::{ClockId, clock_gettime};

/// Worlds of a round.
const WORLDS: u64 = 10;

/// Rounds of each kind.
const ROUNDS: usize = 31;

fn main() {
    println!("| cells | rovers | planner | mode | steps a second | at best |");
    println!("|---|---|---|---|---|---|");
    for (side, rovers) in [(20, 1), (20, 8), (40, 1), (40, 8)] {
        for (algorithm, mode) in [
            (Algorithm::Spiral, CoverMode::Overlap),
            (Algorithm::Spiral, CoverMode::Voronoi),
            (Algorithm::BoustrophedonCircumnavigation, CoverMode::Overlap),
            (Algorithm::CoverFrontier, CoverMode::Overlap),
        ] {
            row(side, rovers, algorithm, mode);
        }
    }
}

fn row(side: u32, rovers: usize, algorithm: Algorithm, mode: CoverMode) {
    let grid = Grid::new(side, side, 1.0, 1).expect("a sound size");
    let world = |seed| World::random(grid, 10.0, seed).expect("so few obstacles fit");
    let worlds: Vec<World> = (0..WORLDS).map(world).collect();
    let setup = |(seed, world): (usize, &World)| {
        let starts = world.random_starts(rovers, seed as u64).expect("there are more free cells than rovers");
        Setup::new(world, algorithm, mode, starts, 95)
    };
    let setups: Vec<Setup> = worlds.iter().enumerate().map(setup).collect();
    let mut rates: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let started_s = processor_s();
            let steps: u64 = worlds.iter().zip(&setups).map(|(world, setup)| fly(world, setup)).sum();
            steps as f64 / (processor_s() - started_s)
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    let mode = if mode == CoverMode::Overlap { "overlap" } else { "voronoi" };
    println!(
        "| {side} × {side} | {rovers} | {algorithm} | {mode} | {:.0} | {:.0} |",
        rates[ROUNDS / 2],
        rates[ROUNDS - 1]
    );
}

/// Processor time of this thread, seconds.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Steps of all rovers together: visits beyond the starts.
fn fly(world: &World, setup: &Setup) -> u64 {
    let mut mission = Mission::new(world, setup).expect("a sound setup");
    while !mission.is_over() {
        mission.round();
    }
    let visits: u64 = world.grid().iter().map(|cell| u64::from(mission.map().visits(cell))).sum();
    visits - setup.starts.len() as u64
}
