//! Decisions on a growing map, after hops that showed new nodes, beside cold solves in the same run.
//!
//! `cargo bench -p hopper-solver --bench online [-- SIDE...]`
//!
//! Times are processor time of this thread, so other load on the machine shows only through the caches. The time of a
//! decision includes the update of the nodes seen. A mission is flown once with cold solves in between. Then one online
//! solver decides again at each hop, and after it another certifies the values of the whole map, each with the caches to
//! itself. `cold/p50` is the median cold solve over the median decision.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

#[path = "../tests/support/mission.rs"]
mod mission;

use mission::Mission;
use rustix::time::{ClockId, clock_gettime};
use solver::fixtures::Fixture;
use solver::online::choice::{CANONICAL_ERROR, TIE};
use solver::online::{Method, OnlineSolver};
use solver::{Effort, Site, Solver, policy};

fn main() {
    let sides: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let sides = if sides.is_empty() { vec![20, 50, 200, 821] } else { sides };
    println!(
        "side radius  hops | way        share |    p50 us    p90 us    p99 us     max us    mean | backups p50 | ns/backup p10 | cold/p50 | mismatches"
    );
    for side in sides {
        for radius in [3.0, 11.0] {
            run(side, radius);
        }
    }
}

/// Processor time of this thread.
fn now_us() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 * 1e-3
}

/// What one benchmark of a side and radius collects over its missions.
#[derive(Default)]
struct Samples {
    /// Processor times of cold solves.
    cold_us: Vec<f64>,
    /// Decisions after hops that showed new nodes: how proven, processor time, backups.
    decisions: Vec<(Method, f64, u64)>,
    /// Certified values of the whole map after such hops: processor time, backups.
    values: Vec<(f64, u64)>,
    /// Decisions compared with the canonical procedure, and how many differed.
    checked: u64,
    mismatches: u64,
}

/// Where the hopper stood, and the nodes that it saw for the first time.
type Sighting = (usize, Vec<(usize, Site)>);

fn run(side: usize, radius: f64) {
    let missions = (400 / side).max(1) as u64;
    let mut solver = Solver::new();
    let mut samples = Samples::default();
    for seed in 0..missions {
        let fixture = Fixture::plain(side, seed + 1);
        let mission = Mission {
            truth: fixture.world().expect("a size in range"),
            unseen: fixture.unseen().expect("a size in range"),
            start: fixture.start(),
            radius,
        };
        let sightings = fly(&mission, seed, &mut solver, &mut samples);
        decide_again(&mission, &sightings, &mut samples);
        certify_again(&mission, &sightings, &mut samples);
    }
    print(side, radius, &mut samples);
}

/// Flies one mission, with cold solves in between.
fn fly(mission: &Mission, seed: u64, solver: &mut Solver, samples: &mut Samples) -> Vec<Sighting> {
    let side = mission.truth.width() as u64;
    let mut sightings = Vec::new();
    let mut rollout = mission.fly(seed);
    let mut online = OnlineSolver::new(mission.unseen.clone());
    for hops in 0_u64.. {
        let mut seen = rollout.seen();
        seen.retain(|(node, site)| online.world().site(*node) != *site);
        for (node, site) in &seen {
            online.update(*node, *site);
        }
        let decision = online.act(rollout.here, None);
        sightings.push((rollout.here, seen));
        // On large worlds only some hops, because cold solves take most of the time.
        if side <= 50 || hops % (2 * side / 5) == 7 {
            let begun_us = now_us();
            solver.solve(online.world(), &Effort::default());
            samples.cold_us.push(now_us() - begun_us);
            solver.solve(online.world(), &Effort { error_max: CANONICAL_ERROR, ..Effort::default() });
            samples.checked += 1;
            let canonical = policy::hop(online.world(), solver.values(), rollout.here, TIE);
            samples.mismatches += u64::from(decision.action != canonical);
        }
        let Some(hop) = decision.action else { break };
        if !rollout.hop(hop) || hops > 4 * side {
            break;
        }
    }
    sightings
}

/// Times the decisions of a mission. Hops that showed nothing new are left out: with nothing to solve, they would make
/// the medians look better.
fn decide_again(mission: &Mission, sightings: &[Sighting], samples: &mut Samples) {
    let mut online = OnlineSolver::new(mission.unseen.clone());
    online.act(sightings[0].0, None);
    for (here, seen) in sightings {
        let begun_us = now_us();
        for (node, site) in seen {
            online.update(*node, *site);
        }
        let decision = online.act(*here, None);
        if !seen.is_empty() {
            samples.decisions.push((decision.method, now_us() - begun_us, decision.work));
        }
    }
}

/// Times the certified values of the whole map.
fn certify_again(mission: &Mission, sightings: &[Sighting], samples: &mut Samples) {
    let mut online = OnlineSolver::new(mission.unseen.clone());
    online.values();
    for (_, seen) in sightings.iter().filter(|(_, seen)| !seen.is_empty()) {
        let begun_us = now_us();
        for (node, site) in seen {
            online.update(*node, *site);
        }
        let work = online.converge_all();
        samples.values.push((now_us() - begun_us, work));
    }
}

fn print(side: usize, radius: f64, samples: &mut Samples) {
    let Samples { cold_us, decisions, values, checked, mismatches } = samples;
    cold_us.sort_by(f64::total_cmp);
    let cold = cold_us[cold_us.len() / 2];
    let hops = decisions.len();
    let line = |way: &str, of: Vec<(f64, u64)>| {
        if of.is_empty() {
            return;
        }
        let mut us: Vec<f64> = of.iter().map(|sample| sample.0).collect();
        let mut work: Vec<u64> = of.iter().map(|sample| sample.1).collect();
        us.sort_by(f64::total_cmp);
        work.sort_unstable();
        // The tenth percentile: the pace while no other process disturbs the core.
        let mut pace: Vec<f64> = of
            .iter()
            .filter(|sample| sample.1 > 2_000)
            .map(|sample| 1e3 * sample.0 / sample.1 as f64)
            .collect();
        pace.sort_by(f64::total_cmp);
        let pace = pace.get(pace.len() / 10).copied().unwrap_or(f64::NAN);
        let at = |share: f64| us[((us.len() - 1) as f64 * share) as usize];
        println!(
            "{side:4} {radius:6} {hops:5} | {way:9} {:6.2}% | {:9.1} {:9.1} {:9.1} {:10.1} {:7.1} | {:11} | {pace:13.2} | {:8.1} | {mismatches} of {checked}",
            100.0 * of.len() as f64 / hops as f64,
            at(0.5),
            at(0.9),
            at(0.99),
            at(1.0),
            us.iter().sum::<f64>() / us.len() as f64,
            work[work.len() / 2],
            cold / at(0.5),
        );
    };
    let by = |method: Method| {
        decisions
            .iter()
            .filter(|decision| decision.0 == method)
            .map(|decision| (decision.1, decision.2))
            .collect()
    };
    line("act: foc.", by(Method::Focused));
    line("act: warm", by(Method::Warm));
    line("act: can.", by(Method::Canonical));
    line("act, all", decisions.iter().map(|decision| (decision.1, decision.2)).collect());
    line("values", std::mem::take(values));
}
