//! Single impacts of the contact engine beside those of Rapier: how far apart, and how many a second.

#![allow(clippy::print_stdout, reason = "a benchmark reports on standard output")]

mod case;
mod peer;

use std::hint::black_box;

use rustix::time::{ClockId, clock_gettime};

use case::{After, BODY, Case, SPEED_MPS};
use peer::Peer;

/// Iterations of Rapier's solver in a step: its default, and many.
const ITERATIONS: [usize; 2] = [4, 64];

/// Median and largest difference of velocity, and of spin times radius, over the speed.
struct Apart {
    count: usize,
    velocity: [f64; 2],
    spin: [f64; 2],
}

impl Apart {
    fn of(pairs: &[[After; 2]]) -> Self {
        let ends = |apart: &dyn Fn(&[After; 2]) -> f64| {
            let mut all: Vec<f64> = pairs.iter().map(apart).collect();
            all.sort_by(f64::total_cmp);
            [all[all.len() / 2], all[all.len() - 1]]
        };
        Self {
            count: pairs.len(),
            velocity: ends(&|[one, other]| (one[0] - other[0]).norm() / SPEED_MPS),
            spin: ends(&|[one, other]| (one[1] - other[1]).norm() * BODY.radius_m / SPEED_MPS),
        }
    }
}

/// Processor time of this process so far, seconds.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Which cases a line of the table is about.
type Kind = (&'static str, fn(&Case) -> bool);

const KINDS: [Kind; 4] = [
    ("without friction", |case| case.friction == 0.0),
    ("sticks", |case| case.friction > 0.0 && case.sticks()),
    ("slides, e = 0", |case| case.friction > 0.0 && !case.sticks() && case.restitution == 0.0),
    ("slides, e > 0", |case| case.friction > 0.0 && !case.sticks() && case.restitution > 0.0),
];

fn main() {
    let cases = Case::grid();
    println!("| impacts | cases | iterations | Δv median | Δv largest | RΔω median | RΔω largest |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let line = |name: &str, iterations: usize, pairs: &[[After; 2]]| {
        let Apart { count, velocity: [v, v_most], spin: [w, w_most] } = Apart::of(pairs);
        println!("| {name} | {count} | {iterations} | {v:.1e} | {v_most:.1e} | {w:.1e} | {w_most:.1e} |");
    };
    for iterations in ITERATIONS {
        let theirs = Peer::new(&cases, iterations).step();
        for (name, is_of) in KINDS {
            let both = cases.iter().zip(&theirs).filter(|(case, _)| is_of(case));
            let pairs: Vec<[After; 2]> = both.clone().map(|(case, after)| [case.ours(), *after]).collect();
            line(name, iterations, &pairs);
            if name == "slides, e > 0" {
                let other: Vec<[After; 2]> =
                    both.map(|(case, after)| [case.ours_with_friction_of_the_stop(), *after]).collect();
                line("… friction of the stop alone", iterations, &other);
            }
        }
    }
    let (mut ours, mut theirs) = ((0_u64, 0.0), (0_u64, 0.0));
    for _ in 0..20 {
        let mut worlds: Vec<Peer> = (0..10).map(|_| Peer::new(&cases, ITERATIONS[0])).collect();
        let begin = processor_s();
        for world in &mut worlds {
            black_box(world.step());
        }
        let middle = processor_s();
        for _ in 0..1_000 {
            for case in &cases {
                black_box(black_box(case).ours());
            }
        }
        let end = processor_s();
        theirs = (theirs.0 + 10 * cases.len() as u64, theirs.1 + middle - begin);
        ours = (ours.0 + 1_000 * cases.len() as u64, ours.1 + end - middle);
    }
    let a_second = |(count, seconds): (u64, f64)| count as f64 / seconds;
    println!();
    println!(
        "impacts a second of processor time: Hopper {:.1e}, Rapier {:.1e} ({} spheres a step)",
        a_second(ours),
        a_second(theirs),
        cases.len()
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_engines_have_the_same_impacts_where_friction_is_that_of_the_stop() {
        let cases = Case::grid();
        let theirs = Peer::new(&cases, ITERATIONS[0]).step();
        for (case, after) in cases.iter().zip(theirs) {
            let ours = case.ours_with_friction_of_the_stop();
            let apart = [(ours[0] - after[0]).norm(), (ours[1] - after[1]).norm() * BODY.radius_m];
            assert!(apart.iter().all(|apart| *apart < 1e-12), "{case:?}: {apart:?}");
        }
    }
}
