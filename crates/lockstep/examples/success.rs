//! Flies a hundred missions with each of some planners: `cargo run --release --example success`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;

use contract::{MonotonicNs, Status};
use lockstep::{Mission, PlannerSchedule, fly};

const MISSIONS: u64 = 100;

fn main() -> Result<(), Box<dyn Error>> {
    let world = scenario::load("sandy")?.resolve()?;
    for planner in ["mdp", "greedy", "astar"] {
        let schedule = PlannerSchedule::single(planner.parse()?);
        let mut reached = 0;
        for seed in 1..=MISSIONS {
            let mission = Mission::of(&world, seed);
            let flown = fly(mission, &schedule, &mut MonotonicNs::default, &mut |_| ())?;
            reached += u64::from(flown.state.status == Status::Goal);
        }
        println!("{planner:6} reaches the goal in {reached} of {MISSIONS} missions");
    }
    Ok(())
}
