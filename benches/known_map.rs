//! Planning on the known 20 × 20 map, start to goal: the MDP, A* and D* Lite beside the times of P23.
//!
//! `cargo bench --bench known_map`. Each figure is the median of so many plans from nothing. The MDP's
//! plan is for every cell at once, in profile `paper-2023`; the others' is one route.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

use std::time::Instant;

use contract::{
    Decision, Digest, Leader, MonotonicNs, ObservedMap, Pose, RobotId, RunId, State, Status, Timing,
};
use planner::{Budget, PlanStatus, Situation};

/// Plans of each kind.
const ROUNDS: usize = 501;

/// Planners with the seconds that the paper reports.
const PUBLISHED_S: [(&str, f64); 3] = [("mdp", 0.065), ("astar", 0.005), ("dstar_lite", 0.016)];

fn main() {
    println!("processor: {}\n", node::host::processor());
    println!("| ground | planner | work | median [us] | paper [us] | ratio |");
    println!("|---|---|---|---|---|---|");
    for ground in ["hard", "heterogeneous", "sandy"] {
        let scenario = scenario::load(ground).expect("a built-in scenario");
        let world = scenario.resolve().expect("a sound scenario");
        let (brief, leg) = (&world.brief, world.brief.leg(0));
        let cells: Vec<_> = world.terrain.cells.iter().copied().map(Some).collect();
        let map = ObservedMap::of_cells(RunId(0), RobotId(0), brief.grid, &cells);
        let height_m = world.terrain.ground(leg.start).expect("a start on the map").height_m;
        let state = State {
            run: RunId(0),
            robot: RobotId(0),
            decision: Decision(0),
            steps: 0,
            status: Status::Underway,
            leader: Leader::default(),
            pose: Pose { cell: leg.start, height_m },
            collected: contract::Collected::default(),
            last: None,
            previous: Digest::default(),
            digest: Digest::default(),
            landed: MonotonicNs(0),
            published: MonotonicNs(0),
            visits: 0,
            vetoed: contract::Vetoed::NONE,
            last_origin: contract::Origin::Planner,
            last_vetoed: contract::Vetoed::NONE,
            last_timing: Timing::default(),
        };
        let situation = Situation::alone(brief, &leg, &map, &state);
        for (name, paper_s) in PUBLISHED_S {
            let mut work = 0;
            let mut times_us: Vec<f64> = (0..ROUNDS)
                .map(|_| {
                    let mut planner = planner::algorithm(name).expect("a known algorithm");
                    let started = Instant::now();
                    let plan = planner.plan(&situation, &Budget::default());
                    let elapsed_us = started.elapsed().as_secs_f64() * 1e6;
                    assert_eq!(plan.status, PlanStatus::Solved);
                    work = plan.work;
                    elapsed_us
                })
                .collect();
            times_us.sort_by(f64::total_cmp);
            let (median_us, paper_us) = (times_us[ROUNDS / 2], paper_s * 1e6);
            println!(
                "| {ground} | {name} | {work} | {median_us:.0} | {paper_us:.0} | {:.0} |",
                paper_us / median_us
            );
        }
    }
}
