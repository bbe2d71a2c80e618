//! Cost over time beside OMPL's RRTstar and BITstar: research/p21/benches/ompl.cpp, built and passed here by ompl.sh.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use p21::{LargeMap, Samples, World, monte_carlo};
use routing::{Goal, Trip, ett_exact, rrt_star_ett};
use rover::{Caution, CostMap, Surface};

use super::{median, timed_ms};

/// Seeds of the planners that sample, ours and OMPL's in turns.
const SEEDS: u64 = 3;

/// Samples of ours on the curve.
const CURVE: [usize; 4] = [1200, 8000, 32_000, 100_000];

/// Processor time that one of OMPL's planners gets.
const GIVEN_S: f64 = 10.0;

/// A cost map as the others understand it: level ground, and a goal that is a point, as BITstar takes it for one.
pub fn plain(world: &World) -> (CostMap, Trip) {
    let costs = world.prior.expected_time(Caution::default());
    let level = CostMap::new(Arc::new(Surface::flat(costs.lattice())), costs.costs().to_vec());
    (level, Trip { goal: Goal { radius_m: 0.0, ..world.trip.goal }, ..world.trip })
}

/// Writes the expected pace of each cell, little-endian, after the side of the map, start and goal; infinite where forbidden.
pub fn write(path: &Path, costs: &CostMap, trip: &Trip) {
    let Trip { start, goal } = trip;
    let head =
        [costs.lattice().width() as f64, start.x_m, start.y_m, goal.at.x_m, goal.at.y_m, goal.radius_m];
    let numbers = head.iter().chain(costs.costs());
    std::fs::write(path, numbers.flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
}

/// A point of a curve of OMPL's.
struct Found {
    ms: f64,
    samples: usize,
    cost: f64,
}

/// OMPL's curves on a map: RRTstar's and BITstar's.
fn others(ompl: &str, map: &Path, seed: u64) -> [Vec<Found>; 2] {
    let output = Command::new(ompl).arg(map).args([seed.to_string(), GIVEN_S.to_string()]).output().unwrap();
    assert!(output.status.success(), "{ompl} ended with {}", output.status);
    let text = String::from_utf8(output.stdout).unwrap();
    ["RRTstar", "BITstar"].map(|name| {
        let lines = text.lines().filter_map(|line| line.strip_prefix(name));
        lines
            .map(|line| {
                let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
                Found { ms: 1e3 * numbers[0], samples: numbers[1] as usize, cost: numbers[2] }
            })
            .collect()
    })
}

/// The median time, or that more than the given time is needed.
fn time(ms: Vec<f64>) -> String {
    let ms = median(ms);
    if ms.is_finite() { format!("{ms:.1}") } else { format!("more than {:.0}", 1e3 * GIVEN_S) }
}

fn ratio(ratios: Vec<f64>) -> String {
    let ratio = median(ratios);
    if ratio.is_finite() { format!("{ratio:.0}") } else { "-".into() }
}

/// Headings of the curve's file.
const HEADINGS: &str = "side,planner,time_ms,above_percent\n";

/// Tables for two maps. The curve, cost above `ett_exact` over time, is also written to the file `curve`, from which
/// `hopper gallery` draws it.
pub fn compare(ompl: &str, curve: &str) {
    let folder = std::env::temp_dir().join(format!("hopper-anytime-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut lines = String::from(HEADINGS);
    let worlds = [
        ("200 × 200 cells", monte_carlo(10_001), Samples::MONTE_CARLO.rover),
        ("821 × 821 cells", LargeMap::new(1, 0.8).world(1), Samples::LARGE.rover),
    ];
    for (name, world, stated) in worlds {
        let (costs, trip) = plain(&world);
        let map = folder.join("map.bin");
        write(&map, &costs, &trip);
        println!("\n## {name}\n");
        table(ompl, &map, &costs, &trip, stated, &mut lines);
    }
    std::fs::write(curve, lines).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
}

/// Time and cost of `rrt_star_ett` by the number of samples.
fn own_curve(costs: &CostMap, trip: &Trip, seed: u64) -> Vec<(f64, f64)> {
    let run = |samples: &usize| {
        let mut cost = f64::INFINITY;
        let plan = || rrt_star_ett(costs, trip, *samples, seed);
        let ms = timed_ms(|| cost = plan().map_or(f64::INFINITY, |route| route.cost));
        (ms, cost)
    };
    CURVE.iter().map(run).collect()
}

fn table(ompl: &str, map: &Path, costs: &CostMap, trip: &Trip, stated: usize, curve: &mut String) {
    let mut exact_ms = Vec::new();
    let mut exact = f64::INFINITY;
    let mut ours: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut curves = Vec::new();
    for seed in 1..=SEEDS {
        exact_ms.push(timed_ms(|| exact = ett_exact(costs, trip, 0.0).unwrap().cost));
        ours.push(own_curve(costs, trip, seed));
        curves.push(others(ompl, map, seed));
    }
    println!("| planner | samples | [ms] | expected Sol | above `ett_exact` |");
    println!("|---|---|---|---|---|");
    let side = costs.lattice().width();
    // `after_ms` is when the planner had found it; of OMPL's the time that it was given.
    let mut line = |planner: &str, samples: String, ms: f64, after_ms: f64, sol: f64| {
        let above = 100.0 * (sol / exact - 1.0);
        println!("| {planner} | {samples} | {ms:.1} | {sol:.4} | {above:.1} % |");
        writeln!(curve, "{side},{planner},{after_ms:.1},{above:.1}").unwrap();
    };
    let exact_median_ms = median(exact_ms.clone());
    line("ett_exact", String::new(), exact_median_ms, exact_median_ms, exact);
    for (at, samples) in CURVE.iter().enumerate() {
        let of = |pick: fn(&(f64, f64)) -> f64| median(ours.iter().map(|runs| pick(&runs[at])).collect());
        let ms = of(|run| run.0);
        line("rrt_star_ett", samples.to_string(), ms, ms, of(|run| run.1));
    }
    for (which, name) in [(0, "RRTstar"), (1, "BITstar")] {
        for given_ms in [10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0] {
            let at: Vec<&Found> = curves
                .iter()
                .filter_map(|both| both[which].iter().rfind(|found| found.ms <= 1.01 * given_ms))
                .collect();
            if at.len() == curves.len() {
                let samples = median(at.iter().map(|found| found.samples as f64).collect());
                let samples = if which == 0 { samples.to_string() } else { String::new() };
                let ms = median(at.iter().map(|found| found.ms).collect());
                line(name, samples, ms, given_ms, median(at.iter().map(|found| found.cost).collect()));
            }
        }
    }
    println!("\n| OMPL, until | ours [ms] | RRTstar [ms] | ratio | BITstar [ms] | ratio |");
    println!("|---|---|---|---|---|---|");
    let at = CURVE.iter().position(|samples| *samples == stated).unwrap();
    let own = |seed: usize| ours[seed][at];
    let own_ms: Vec<f64> = (0..curves.len()).map(|seed| own(seed).0).collect();
    // Time and ratio of one of OMPL's planners, until something is reached.
    let of = |which: usize, own_ms: &[f64], reached: &dyn Fn(usize, &Found) -> bool| {
        let times = |seed: usize| {
            let found = curves[seed][which].iter().find(|found| reached(seed, found));
            let ms = found.map_or(f64::INFINITY, |found| found.ms);
            (ms, ms / own_ms[seed])
        };
        let (ms, ratios) = (0..curves.len()).map(times).unzip();
        format!("{} | {}", time(ms), ratio(ratios))
    };
    let until = |what: &str, own_ms: &[f64], reached: &dyn Fn(usize, &Found) -> bool| {
        let [rrt, bit] = [0, 1].map(|which| of(which, own_ms, reached));
        println!("| {what} | {:.1} | {rrt} | {bit} |", median(own_ms.to_vec()));
    };
    let rrt = of(0, &own_ms, &|_, found| found.samples >= stated);
    println!("| as many samples as `rrt_star_ett` | {:.1} | {rrt} | | |", median(own_ms.clone()));
    until("the cost of `rrt_star_ett`", &own_ms, &|seed, found| found.cost <= own(seed).1);
    for above in [5.0, 1.0, 0.1] {
        let limit = exact * (1.0 + above / 100.0);
        until(&format!("{above} % above `ett_exact`"), &exact_ms, &|_, found| found.cost <= limit);
    }
}
