//! Planning on the known ground of Sakamoto & Kubota 2022, beside the times that they give.
//!
//! `cargo bench --bench known_ground`. Each figure is the median of so many plans from nothing: world,
//! collision checks, model, value iteration, path. Sweeps are those that choose; at the smaller change twelve
//! that keep their choices lie between two of them.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

use std::hint::black_box;
use std::time::Instant;

use p22::{Experiment, P22, Plan, Reading, Weights};

/// Plans of each kind.
const ROUNDS: usize = 101;

/// Seconds that the paper reports; it times the grounds with hills alike.
fn published_s(experiment: Experiment) -> f64 {
    if experiment == Experiment::Rocks { 0.55 } else { 0.79 }
}

fn main() {
    println!("processor: {}\n", node::host::processor());
    println!("| world | stop at a change of | sweeps | median [ms] | paper [ms] | ratio |");
    println!("|---|---|---|---|---|---|");
    let weights = Weights::new(0.5, Weights::GOAL).expect("weights within bounds");
    for experiment in Experiment::ALL {
        for tolerance in [P22.tolerance, 1e-9] {
            let reading = Reading { tolerance, ..P22 };
            let mut sweeps = 0;
            let mut times_ms: Vec<f64> = (0..ROUNDS)
                .map(|_| {
                    let started = Instant::now();
                    let plan = black_box(Plan::of(experiment, &reading, weights));
                    let elapsed_ms = started.elapsed().as_secs_f64() * 1e3;
                    sweeps = plan.solution.sweeps;
                    elapsed_ms
                })
                .collect();
            times_ms.sort_by(f64::total_cmp);
            let (median_ms, paper_ms) = (times_ms[ROUNDS / 2], published_s(experiment) * 1e3);
            println!(
                "| {experiment} | {tolerance:e} | {sweeps} | {median_ms:.2} | {paper_ms:.0} | {:.0} |",
                paper_ms / median_ms
            );
        }
    }
}
