//! How fast the planners of rover and helicopter are, beside plain implementations and other people's.
//!
//! `cargo bench -p p21 --bench routes`. One thread. Each figure is the median of rounds, in processor time of the thread, so that
//! other load on the machine counts less; what is compared is measured in turns. `-- --raster FILE` writes the cost map of the large world
//! instead, for `research/p21/benches/eikonal.py`; `-- --quality` only compares the cost of routes; `-- --anytime PROGRAM FILE` compares with OMPL
//! and writes the anytime curve (`research/p21/benches/ompl.sh`).

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]
#![allow(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

mod anytime;
mod plain;

use std::hint::black_box;

use helicopter::{BUDGET_M, Camera, scout};
use kiddo::{KdTree, SquaredEuclidean};
use p21::{Arm, LargeMap, RoverPlanner, Samples, Setup, World, announce, fly, monte_carlo, monte_carlo_of};
use routing::{
    BucketGrid, KeptClear, RrtStarIt, Stream, Trip, ett_exact, pull_tight, rrt_star_ett, rrt_star_it,
};
use rover::{Belief, Caution, CostMap, Lattice, Point};
use rustix::time::{ClockId, clock_gettime};

/// Rounds of each row, each on a world of its own where worlds are drawn.
const ROUNDS: u64 = 5;

/// Worlds on which the cost of routes is compared.
const WORLDS: u64 = 1000;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|word| word == "--raster") {
        return raster(&arguments[at + 1]);
    }
    if let Some(at) = arguments.iter().position(|word| word == "--anytime") {
        return anytime::compare(&arguments[at + 1], &arguments[at + 2]);
    }
    if arguments.iter().any(|word| word == "--quality") {
        return quality();
    }
    println!("| what | ours [ms] | beside it | [ms] | ratio |");
    println!("|---|---|---|---|---|");
    missions();
    exact();
    println!();
    quality();
    println!("\n| what | ours | beside it | | ratio |");
    println!("|---|---|---|---|---|");
    neighbours();
    println!("\n| RRT* of the rover | N | N a second | expected Sol | `ett_exact` |");
    println!("|---|---|---|---|---|");
    samples();
}

/// Processor time of this thread, seconds.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn timed_ms<T>(work: impl FnOnce() -> T) -> f64 {
    let started_s = processor_s();
    black_box(work());
    1e3 * (processor_s() - started_s)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A row of ours and of another one, measured in turns.
fn row(what: &str, beside: &str, rounds: u64, mut ours: impl FnMut(u64), mut other: impl FnMut(u64)) {
    let (mut own_ms, mut other_ms) = (Vec::new(), Vec::new());
    for round in 0..rounds {
        own_ms.push(timed_ms(|| ours(round)));
        other_ms.push(timed_ms(|| other(round)));
    }
    let ratios = own_ms.iter().zip(&other_ms).map(|(own, other)| other / own).collect();
    println!(
        "| {what} | {:.2} | {beside} | {:.2} | {:.1} |",
        median(own_ms),
        median(other_ms),
        median(ratios)
    );
}

/// One world of the Monte Carlo study: the rover's route, the flight, the second route.
fn missions() {
    let worlds: Vec<World> = (0..ROUNDS).map(|run| monte_carlo(10_001 + run)).collect();
    let setup = Setup::new(RoverPlanner::RrtStarEtt, Samples::MONTE_CARLO);
    row(
        "rover and information-theoretic helicopter, 200 × 200 cells, N = 1200 and 600",
        "plain",
        ROUNDS,
        |round| {
            let (world, seed) = (&worlds[round as usize], 10_001 + round);
            let announced = announce(world, &setup, seed);
            black_box(fly(world, Arm::InformationTheoretic, &setup, seed, announced.as_ref()));
        },
        |round| {
            let (world, seed) = (&worlds[round as usize], 10_001 + round);
            let view_m = Camera::default().radius_m();
            let plan = |costs: &CostMap, seed| {
                plain::rrt_star_ett(costs, &world.trip, Samples::MONTE_CARLO.rover, seed)
            };
            black_box(plan(&world.prior.expected_time(Caution::default()), seed));
            let start = world.trip.start;
            let flight =
                plain::rrt_star_it(&world.prior, start, Samples::MONTE_CARLO.helicopter, view_m, seed);
            let mut belief = world.prior.clone();
            scout(&mut belief, &world.truth, &flight, view_m);
            black_box(plan(&belief.expected_time(Caution::default()), !seed));
        },
    );
    parts(&worlds);
    let map = LargeMap::new(1, 0.8);
    let setup = Setup::new(RoverPlanner::RrtStarEtt, Samples::LARGE);
    let worlds: Vec<World> = (0..5).map(|run| map.world(run)).collect();
    let own_ms = (0..5).map(|run| {
        timed_ms(|| {
            let announced = announce(&worlds[run as usize], &setup, run);
            fly(&worlds[run as usize], Arm::InformationTheoretic, &setup, run, announced.as_ref())
        })
    });
    let own_ms = median(own_ms.collect());
    println!("| the same on 821 × 821 cells, N = 8000 and 3000 | {own_ms:.1} | | | |");
}

/// Prints the time of each planner on its own.
fn parts(worlds: &[World]) {
    let costs: Vec<CostMap> =
        worlds.iter().map(|world| world.prior.expected_time(Caution::default())).collect();
    let Samples { rover, helicopter } = Samples::MONTE_CARLO;
    row(
        "`rrt_star_ett` alone, N = 1200",
        "plain",
        ROUNDS,
        |round| {
            let at = round as usize;
            black_box(rrt_star_ett(&costs[at], &worlds[at].trip, rover, round));
        },
        |round| {
            let at = round as usize;
            black_box(plain::rrt_star_ett(&costs[at], &worlds[at].trip, rover, round));
        },
    );
    let view_m = Camera::default().radius_m();
    row(
        "`rrt_star_it` alone, N = 600",
        "plain",
        ROUNDS,
        |round| {
            let world = &worlds[round as usize];
            let settings = RrtStarIt { iterations: helicopter, budget_m: BUDGET_M, view_m };
            black_box(rrt_star_it(&world.prior, world.trip.start, &settings, round));
        },
        |round| {
            let world = &worlds[round as usize];
            black_box(plain::rrt_star_it(&world.prior, world.trip.start, helicopter, view_m, round));
        },
    );
}

/// Which of the three passages of the Monte Carlo world a route leads through last; discs part them in the middle column.
fn passage(points: &[Point]) -> Option<usize> {
    const MIDDLE_M: f64 = 100.0;
    let crosses = |pair: &&[Point]| (pair[0].x_m < MIDDLE_M) != (pair[1].x_m < MIDDLE_M);
    let pair = points.windows(2).rfind(crosses)?;
    let share = (MIDDLE_M - pair[0].x_m) / (pair[1].x_m - pair[0].x_m);
    let y_m = pair[0].y_m + share * (pair[1].y_m - pair[0].y_m);
    Some([62.5, 137.5].iter().filter(|disc_m| y_m > **disc_m).count())
}

/// How much dearer than `ett_exact` the rover's routes are, by what was known when they were planned.
fn quality() {
    println!("| routes of N = 1200 on {WORLDS} worlds | median above `ett_exact` | 90 % of them below |");
    println!("|---|---|---|");
    let setup = Setup::new(RoverPlanner::RrtStarEtt, Samples::MONTE_CARLO);
    let (mut first, mut tight, mut driven, mut elsewhere) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for seed in 10_001..10_001 + WORLDS {
        let world = monte_carlo(seed);
        let exact =
            |belief: &Belief| ett_exact(&belief.expected_time(Caution::default()), &world.trip, 0.0).unwrap();
        let announced = announce(&world, &setup, seed);
        let Some(route) = &announced else { continue };
        let best = exact(&world.prior);
        elsewhere += usize::from(passage(&route.points) != passage(&best.points));
        first.push(100.0 * (route.cost / best.cost - 1.0));
        let costs = world.prior.expected_time(Caution::default());
        let mut points = route.points.clone();
        pull_tight(&KeptClear::none(&costs), &mut points);
        tight.push(100.0 * (costs.way(&points) / best.cost - 1.0));
        let outcome = fly(&world, Arm::InformationTheoretic, &setup, seed, announced.as_ref());
        let mut belief = world.prior.clone();
        scout(&mut belief, &world.truth, &outcome.flight, Camera::default().radius_m());
        driven.push(100.0 * (outcome.expected_sol / exact(&belief).cost - 1.0));
    }
    let rows = [
        ("announced on the prior", first),
        ("… pulled tight as `ett_exact` does", tight),
        ("driven after the flight", driven),
    ];
    for (name, mut above) in rows {
        above.sort_by(f64::total_cmp);
        let (middle, most) = (above[above.len() / 2], above[above.len() * 9 / 10]);
        println!("| {name} | {middle:.1} % | {most:.1} % |");
    }
    println!("\n{elsewhere} of the routes announced lead through another passage than those of `ett_exact`");
}

/// The complete search on 674,041 cells.
fn exact() {
    let hilly = LargeMap::new(1, 0.8).world(1);
    let flat = monte_carlo_of(821, 1);
    for (name, world) in [("hilly", &hilly), ("level", &flat)] {
        let costs = world.prior.expected_time(Caution::default());
        let Trip { start, goal } = world.trip;
        row(
            &format!("`ett_exact` on 821 × 821 cells, {name}"),
            "Dijkstra to the goal",
            ROUNDS,
            |_| {
                black_box(ett_exact(&costs, &world.trip, 0.0));
            },
            |_| {
                black_box(plain::dijkstra(&costs, start, Some(goal.at)));
            },
        );
        let closed = walled_in(&costs, goal.at);
        row(
            &format!("the same with the goal walled in, so that it searches the whole map, {name}"),
            "Dijkstra to all cells",
            ROUNDS,
            |_| assert!(ett_exact(&closed, &world.trip, 0.0).is_none()),
            |_| {
                black_box(plain::dijkstra(&closed, start, None));
            },
        );
    }
}

/// The map with a forbidden ring around a point.
fn walled_in(costs: &CostMap, middle: Point) -> CostMap {
    let ring = 3.0..8.0;
    let rates = costs.costs().iter().enumerate().map(|(cell, rate)| {
        let away_m = costs.lattice().centre(cell).distance_m(middle);
        if ring.contains(&away_m) { f64::INFINITY } else { *rate }
    });
    CostMap::new(costs.surface().clone(), rates.collect())
}

/// Six nearest points and those around, while 100,000 points come in one by one, as RRT* asks for them.
fn neighbours() {
    const POINTS: usize = 100_000;
    let lattice = Lattice::new(200, 200).unwrap();
    let near_m = |n: usize| (140.0 * ((n as f64).ln() / n as f64).sqrt()).min(25.0);
    let mut draws = Stream::new(1, "benchmark");
    let points: Vec<Point> =
        (0..POINTS).map(|_| Point::new(draws.between(0.0, 200.0), draws.between(0.0, 200.0))).collect();
    let (mut own_ns, mut other_ns) = (Vec::new(), Vec::new());
    for _ in 0..5 {
        let (mut found, mut own, mut other) = (Vec::new(), 0, 0);
        own_ns.push(timed_ms(|| {
            let mut grid = BucketGrid::new(lattice, POINTS);
            grid.insert(points[0]);
            for (n, at) in points.iter().enumerate().skip(1) {
                grid.nearest(*at, 6, &mut found);
                own += found.len();
                grid.within(*at, near_m(n), &mut found);
                own += found.len();
                grid.insert(*at);
            }
        }));
        other_ns.push(timed_ms(|| {
            let mut tree: KdTree<f64, 2> = KdTree::new();
            tree.add(&[points[0].x_m, points[0].y_m], 0);
            for (n, at) in points.iter().enumerate().skip(1) {
                let at = [at.x_m, at.y_m];
                other += tree.nearest_n::<SquaredEuclidean>(&at, 6).len();
                let reach_m = near_m(n);
                other += tree.within_unsorted::<SquaredEuclidean>(&at, reach_m * reach_m).len();
                tree.add(&at, n as u64);
            }
        }));
        assert!(own.abs_diff(other) <= 2, "both find the same points: {own} and {other}");
    }
    let (own, other) = (median(own_ns), median(other_ns));
    let rate = |ms: f64| POINTS as f64 / ms * 1e3;
    println!(
        "| points a second, two queries each, up to 100,000 points: bucket grid | {:.0} | k-d tree of kiddo | {:.0} | {:.1} |",
        rate(own),
        rate(other),
        other / own
    );
}

/// How the rover's RRT* slows down and improves with its number of samples.
fn samples() {
    let world = monte_carlo(10_001);
    let costs = world.prior.expected_time(Caution::default());
    let exact = ett_exact(&costs, &world.trip, 0.0).unwrap().cost;
    for iterations in [1200, 8000, 100_000] {
        let mut sol = 0.0;
        let ms = (0..3).map(|round| {
            timed_ms(|| sol = rrt_star_ett(&costs, &world.trip, iterations, round).unwrap().cost)
        });
        let rate = iterations as f64 / median(ms.collect()) * 1e3;
        println!("| `rrt_star_ett` | {iterations} | {rate:.0} | {sol:.4} | {exact:.4} |");
    }
}

/// Writes the large world for scikit-fmm, and measures what solves the same.
fn raster(path: &str) {
    let (costs, trip) = anytime::plain(&LargeMap::new(1, 0.8).world(1));
    anytime::write(std::path::Path::new(path), &costs, &trip);
    let closed = walled_in(&costs, trip.goal.at);
    let mut route = None;
    let (mut directed_ms, mut whole_ms, mut plain_ms) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        directed_ms.push(timed_ms(|| route = ett_exact(&costs, &trip, 0.0)));
        whole_ms.push(timed_ms(|| ett_exact(&closed, &trip, 0.0)));
        plain_ms.push(timed_ms(|| plain::dijkstra(&costs, trip.start, None)));
    }
    println!("ett_exact: {:.1} ms, {:.4} Sol", median(directed_ms), route.unwrap().cost);
    println!("the whole map: {:.1} ms; plain Dijkstra {:.1} ms", median(whole_ms), median(plain_ms));
}
