//! Tables 3, 4, 6, 7, 9 and 10 of Sakamoto & Kunii 2023, flown by the stack's own engines in lockstep.
//!
//! `cargo run --release --example paper_table [MISSIONS]` prints, for each ground, planner and weighting
//! and in both profiles: success, steps mean ± sd over successes as the paper counts them, and the
//! restricted mean, in which a failure counts as the step limit. Every cell has seeds of its own.

#![allow(clippy::print_stdout, reason = "an example's output is its data")]

use contract::{Brief, MonotonicNs, Profile, RunId, Status, Weights};
use hopper::lockstep::{self, Crew};
use hopper_sim::Mission;
use scenario::Overrides;

/// Grounds with the paper's successes of 100 and mean steps: MDP then greedy, weights (1,0), (.5,.5), (0,1).
type Published = [(f64, f64); 3];
const GROUNDS: [(&str, Published, Published); 3] = [
    ("hard", [(99.0, 75.7), (98.0, 75.0), (99.0, 76.0)], [(99.0, 75.5), (100.0, 76.9), (99.0, 76.5)]),
    (
        "heterogeneous",
        [(100.0, 77.5), (100.0, 76.5), (99.0, 76.3)],
        [(5.0, 107.2), (99.0, 92.6), (99.0, 83.0)],
    ),
    ("sandy", [(81.0, 111.7), (92.0, 114.9), (93.0, 117.7)], [(41.0, 127.7), (86.0, 120.1), (89.0, 121.2)]),
];
const WEIGHTS: [(f64, f64); 3] = [(1.0, 0.0), (0.5, 0.5), (0.0, 1.0)];

fn main() {
    let missions = std::env::args().nth(1).map_or(1000, |text| text.parse().expect("a number of missions"));
    println!("{missions} missions a cell; success %, steps mean ± sd over successes, restricted mean");
    for profile in Profile::ALL {
        println!("\n| {profile} | planner | w1, w2 | paper | success | steps | restricted |");
        println!("|---|---|---|---|---|---|---|");
        let mut first_seed = 0;
        for (ground, mdp, greedy) in GROUNDS {
            for (planner, published) in [("mdp", mdp), ("greedy", greedy)] {
                for ((safety, information), (successes, steps)) in WEIGHTS.into_iter().zip(published) {
                    first_seed += 1_000_000;
                    let cell = Cell { ground, profile, planner, safety, information, first_seed };
                    let Tally { success, mean, deviation, restricted } = cell.fly(missions);
                    println!(
                        "| {ground} | {planner} | {safety}, {information} | {successes:.0} %, {steps} | \
                         {success:.1} % | {mean:.1} ± {deviation:.1} | {restricted:.1} |"
                    );
                }
            }
        }
    }
}

/// One cell of the tables.
struct Cell {
    ground: &'static str,
    profile: Profile,
    planner: &'static str,
    safety: f64,
    information: f64,
    first_seed: u64,
}

/// What the missions of a cell came to.
struct Tally {
    success: f64,
    mean: f64,
    deviation: f64,
    restricted: f64,
}

impl Cell {
    fn fly(&self, missions: u64) -> Tally {
        let overrides = Overrides { profile: Some(self.profile), ..Overrides::default() };
        let scenario = scenario::load(self.ground).expect("a built-in scenario");
        let world = scenario.with(&overrides).resolve().expect("a sound scenario");
        let weights = Weights { safety: self.safety, information: self.information, ..world.brief.weights };
        let crew = Crew::single(self.planner.parse().expect("a name"));
        let limit = world.brief.limits.steps_max as f64;
        let mut steps = Vec::new();
        for seed in self.first_seed..self.first_seed + missions {
            let brief = Brief { run: RunId(1), weights, ..world.brief };
            let mission = Mission { brief, terrain: world.terrain.clone(), seed };
            let flown = lockstep::fly(mission, &crew, &mut || MonotonicNs(0), &mut |_| ())
                .expect("a known algorithm");
            if flown.state.status == Status::Goal {
                steps.push(flown.state.steps as f64);
            }
        }
        let count = steps.len() as f64;
        let sum: f64 = steps.iter().sum();
        let mean = sum / count;
        let squares: f64 = steps.iter().map(|steps| (steps - mean).powi(2)).sum();
        Tally {
            success: 100.0 * count / missions as f64,
            mean,
            deviation: (squares / (count - 1.0)).sqrt(),
            restricted: (sum + (missions as f64 - count) * limit) / missions as f64,
        }
    }
}
