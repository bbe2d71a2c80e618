//! Decisions on a growing map after hops that brought news, beside cold solves in the same run.
//!
//! `cargo bench -p solver --bench online [-- SIDE...]`
//!
//! Times are of this thread's processor: what others do to the machine shows only in its caches. A decision's
//! includes taking in what was seen. A mission is flown once with cold solves in between; then one session decides
//! again at each hop, and after it another certifies the values of the whole map, each with the caches to itself.
//! `cold/p50` is the median cold solve over the median decision.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

#[path = "../tests/support/mission.rs"]
mod mission;

use mission::Mission;
use rustix::time::{ClockId, clock_gettime};
use solver::fixtures::Fixture;
use solver::online::choice::{CANONICAL_ERROR, TIE};
use solver::online::{Method, OnlineSolver};
use solver::{Effort, Solver, policy};

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

fn run(side: usize, radius: f64) {
    let missions = (400 / side).max(1) as u64;
    let mut solver = Solver::new();
    let mut cold_us = Vec::new();
    let (mut acts, mut warms) = (Vec::new(), Vec::new());
    let (mut checked, mut mismatches) = (0_u64, 0_u64);
    for seed in 0..missions {
        let fixture = Fixture::plain(side, seed + 1);
        let mission = Mission {
            truth: fixture.world().expect("a size in range"),
            unseen: fixture.unseen().expect("a size in range"),
            start: fixture.start(),
            radius,
        };
        // What was seen, and from where, hop by hop.
        let mut news = Vec::new();
        let mut flight = mission.fly(seed);
        let mut pilot = OnlineSolver::new(mission.unseen.clone());
        for hops in 0_u64.. {
            let mut seen = flight.seen();
            seen.retain(|(node, site)| pilot.world().site(*node) != *site);
            for (node, site) in &seen {
                pilot.update(*node, *site);
            }
            let decision = pilot.act(flight.here, None);
            news.push((flight.here, seen));
            // A cold solve now and then: it is what takes the time.
            if side <= 50 || hops % (2 * side as u64 / 5) == 7 {
                let begun_us = now_us();
                solver.solve(pilot.world(), &Effort::default());
                cold_us.push(now_us() - begun_us);
                solver.solve(pilot.world(), &Effort { error_max: CANONICAL_ERROR, ..Effort::default() });
                checked += 1;
                let canonical = policy::hop(pilot.world(), solver.values(), flight.here, TIE);
                mismatches += u64::from(decision.action != canonical);
            }
            let Some(hop) = decision.action else { break };
            if !flight.hop(hop) || hops > 4 * side as u64 {
                break;
            }
        }
        // Where nothing new was seen, there is nothing to solve: such hops would flatter the medians.
        let mut focused = OnlineSolver::new(mission.unseen.clone());
        focused.act(news[0].0, None);
        for (here, seen) in &news {
            let begun_us = now_us();
            for (node, site) in seen {
                focused.update(*node, *site);
            }
            let decision = focused.act(*here, None);
            if !seen.is_empty() {
                acts.push((decision.method, now_us() - begun_us, decision.work));
            }
        }
        let mut warm = OnlineSolver::new(mission.unseen.clone());
        warm.values();
        for (_, seen) in news.iter().filter(|(_, seen)| !seen.is_empty()) {
            let begun_us = now_us();
            for (node, site) in seen {
                warm.update(*node, *site);
            }
            let work = warm.converge_all();
            warms.push((now_us() - begun_us, work));
        }
    }
    cold_us.sort_by(f64::total_cmp);
    let cold = cold_us[cold_us.len() / 2];
    let hops = acts.len();
    let line = |way: &str, of: Vec<(f64, u64)>, total: usize| {
        if of.is_empty() {
            return;
        }
        let mut us: Vec<f64> = of.iter().map(|act| act.0).collect();
        let mut work: Vec<u64> = of.iter().map(|act| act.1).collect();
        us.sort_by(f64::total_cmp);
        work.sort_unstable();
        // The pace when nobody else wants the core.
        let mut pace: Vec<f64> =
            of.iter().filter(|act| act.1 > 2_000).map(|act| 1e3 * act.0 / act.1 as f64).collect();
        pace.sort_by(f64::total_cmp);
        let pace = pace.get(pace.len() / 10).copied().unwrap_or(f64::NAN);
        let at = |share: f64| us[((us.len() - 1) as f64 * share) as usize];
        println!(
            "{side:4} {radius:6} {hops:5} | {way:9} {:6.2}% | {:9.1} {:9.1} {:9.1} {:10.1} {:7.1} | {:11} | {pace:13.2} | {:8.1} | {mismatches} of {checked}",
            100.0 * of.len() as f64 / total as f64,
            at(0.5),
            at(0.9),
            at(0.99),
            at(1.0),
            us.iter().sum::<f64>() / us.len() as f64,
            work[work.len() / 2],
            cold / at(0.5),
        );
    };
    let of = |method: Method| acts.iter().filter(|act| act.0 == method).map(|act| (act.1, act.2)).collect();
    line("act: foc.", of(Method::Focused), hops);
    line("act: warm", of(Method::Warm), hops);
    line("act: can.", of(Method::Canonical), hops);
    line("act, all", acts.iter().map(|act| (act.1, act.2)).collect(), hops);
    line("values", warms, hops);
}
