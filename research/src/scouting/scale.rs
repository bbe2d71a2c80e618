//! P21's table of scalability, and its Markov decision processes (Figs 18 and 19).

use std::time::Instant;

use ::campaign::statistics::wilson;
use ::report::picture::FieldMap;
use node::{Exit, Failure};
use p21::{Arm, GridMdp, RoverPlanner, Samples, Setup, Spread, World, announce, fly, monte_carlo_of};
use routing::ett_exact;
use rover::Caution;
use serde::Serialize;

use super::FOLSOM;
use crate::claims::{Claim, Verdict};
use crate::form::{Form, table};
use crate::report::{Publication, Report, percent};

/// Arguments of the table of scalability.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Times that each size is measured; the median counts.
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Seed of the world.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    #[command(flatten)]
    publication: Publication,
}

/// Sides with what the paper needed, in seconds: MCTS for a process that it does not describe, then its own two-stage algorithm.
const SIDES: [(usize, Option<f64>, Option<f64>); 7] = [
    (10, Some(0.4), None),
    (15, Some(18.63), None),
    (20, Some(106.14), None),
    (50, None, None),
    (100, None, None),
    (200, None, Some(1262.0)),
    (821, None, Some(1648.0)),
];

/// Greatest change of a value in the last sweep.
const TOLERANCE: f64 = 1e-6;

/// Side of the worlds of Figs 18 and 19, and of those on which agents are followed.
const FIGURE_SIDE: usize = 50;

/// Worlds on which agents are followed.
const FOLLOWED: u64 = 100;

/// What one size took; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Row {
    side: usize,
    cells: usize,
    sweeps: usize,
    value_iteration_s: f64,
    ett_exact_s: f64,
    samples: Samples,
    mission_s: f64,
    paper_mcts_s: Option<f64>,
    paper_mission_s: Option<f64>,
}

/// The whole table; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Account {
    rounds: u32,
    seed: u64,
    rows: Vec<Row>,
    claims: Vec<Claim>,
}

/// Measures each size, and prints the table.
///
/// # Errors
/// Exit code 2 if the folder for the figures cannot be created, 1 if the report cannot be printed or written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let rows: Vec<Row> = SIDES.iter().map(|size| row(*size, args)).collect();
    let claims = judge(args, &rows);
    args.publication.publish(&Account { rounds: args.rounds, seed: args.seed, rows, claims })
}

/// The median time of `work`, in seconds, with its last result.
fn timed<T>(rounds: u32, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut once = || {
        let started = Instant::now();
        let result = work();
        (started.elapsed().as_secs_f64(), result)
    };
    let (first_s, mut result) = once();
    let mut times_s = vec![first_s];
    for _ in 1..rounds {
        let (time_s, next) = once();
        times_s.push(time_s);
        result = next;
    }
    times_s.sort_by(f64::total_cmp);
    (times_s[times_s.len() / 2], result)
}

fn goal_cell(world: &World) -> usize {
    world.prior.surface().lattice().cell(world.trip.goal.at)
}

fn row((side, paper_mcts_s, paper_mission_s): (usize, Option<f64>, Option<f64>), args: &Args) -> Row {
    let world = monte_carlo_of(side, args.seed);
    let cells = world.prior.cells().len();
    let samples = if cells > 40_000 { Samples::LARGE } else { Samples::MONTE_CARLO };
    let (value_iteration_s, solution) =
        timed(args.rounds, || GridMdp::new(&world.prior, Some(goal_cell(&world))).solve(TOLERANCE));
    let (ett_exact_s, _) =
        timed(args.rounds, || ett_exact(&world.prior.expected_time(Caution::default()), &world.trip, 0.0));
    let setup = Setup::new(RoverPlanner::RrtStarEtt, samples);
    let (mission_s, _) = timed(args.rounds, || {
        let announced = announce(&world, &setup, args.seed);
        fly(&world, Arm::InformationTheoretic, &setup, args.seed, announced.as_ref())
    });
    Row {
        side,
        cells,
        sweeps: solution.sweeps,
        value_iteration_s,
        ett_exact_s,
        samples,
        mission_s,
        paper_mcts_s,
        paper_mission_s,
    }
}

/// On how many of the worlds followed an agent comes back to a cell before it reaches its goal.
fn trapped(seed: u64) -> Spread {
    let is_trapped = |seed: &u64| {
        let world = monte_carlo_of(FIGURE_SIDE, *seed);
        let mdp = GridMdp::new(&world.prior, Some(goal_cell(&world)));
        let start = world.prior.surface().lattice().cell(world.trip.start);
        mdp.likeliest_way(&mdp.solve(TOLERANCE), start).last() != Some(&goal_cell(&world))
    };
    let count = (0..FOLLOWED).map(|world| seed.wrapping_add(world)).filter(is_trapped).count() as u64;
    let interval = wilson(count, FOLLOWED);
    Spread { value: count as f64 / FOLLOWED as f64, low: interval.low, high: interval.high }
}

fn judge(args: &Args, rows: &[Row]) -> Vec<Claim> {
    let large = rows.last().expect("sizes");
    let middle = rows.iter().find(|row| row.side == 200).expect("the size of the Monte Carlo world");
    let trapped = trapped(args.seed);
    vec![
        Claim::new(
            "value iteration is intractable for large maps",
            "yes",
            "it takes more than an hour on 821 × 821 cells, for the process described above",
            seconds(large.value_iteration_s),
            Verdict::of(large.value_iteration_s > 3600.0),
        ),
        Claim::new(
            "it tends to become trapped in local maxima",
            "yes",
            "in most of 100 worlds of 50 × 50 cells the likeliest way comes back to a cell before it reaches the goal",
            percent(trapped),
            Verdict::within(trapped, 0.5, 1.0),
        ),
        Claim::new(
            "MCTS takes 0.4, 18.6 and 106 s on 10 × 10, 15 × 15 and 20 × 20 cells, SARSOP and DESPOT 389 and 89 s",
            "yes",
            "the paper does not describe its partially observable processes",
            String::new(),
            Verdict::NotToBeHad,
        ),
        Claim::new(
            "RRT* solves large maps without excessive computation",
            "1262 s and 1648 s a run",
            "less than the paper needs, on 200 × 200 and 821 × 821 cells",
            format!("{} and {}", seconds(middle.mission_s), seconds(large.mission_s)),
            Verdict::of(middle.mission_s < 1262.0 && large.mission_s < 1648.0),
        ),
    ]
}

/// A time with three figures that count.
fn seconds(time_s: f64) -> String {
    if time_s < 1e-3 {
        format!("{:.0} µs", 1e6 * time_s)
    } else if time_s < 1.0 {
        format!("{:.1} ms", 1e3 * time_s)
    } else {
        format!("{time_s:.2} s")
    }
}

impl Report for Account {
    const NAME: &'static str = "scouting-scale";
    const PAPER: &'static str = FOLSOM;

    fn title(&self) -> String {
        "Scalability".into()
    }

    fn tables(&self, form: Form) -> String {
        let optional = |time_s: Option<f64>| time_s.map_or(String::new(), |time_s| format!("{time_s} s"));
        let cells = |row: &Row| {
            [
                format!("{0} × {0}", row.side),
                seconds(row.value_iteration_s),
                row.sweeps.to_string(),
                seconds(row.ett_exact_s),
                seconds(row.mission_s),
                format!("{}, {}", row.samples.rover, row.samples.helicopter),
                optional(row.paper_mcts_s),
                optional(row.paper_mission_s),
            ]
        };
        let headings = [
            "cells",
            "value iteration",
            "sweeps",
            "ett_exact",
            "rover and helicopter",
            "N of both",
            "paper: MCTS",
            "paper: rover and helicopter",
        ];
        table(form, headings, &self.rows.iter().map(cells).collect::<Vec<_>>()) + "\n"
    }

    fn records(&self) -> Vec<Vec<String>> {
        let headings = ["cells", "value_iteration_s", "sweeps", "ett_exact_s", "mission_s"].map(String::from);
        let record = |row: &Row| {
            let Row { cells, value_iteration_s, sweeps, ett_exact_s, mission_s, .. } = row;
            let times = [value_iteration_s, ett_exact_s, mission_s].map(ToString::to_string);
            let [value_iteration_s, ett_exact_s, mission_s] = times;
            vec![cells.to_string(), value_iteration_s, sweeps.to_string(), ett_exact_s, mission_s]
        };
        std::iter::once(headings.into()).chain(self.rows.iter().map(record)).collect()
    }

    fn claims(&self) -> &[Claim] {
        &self.claims
    }

    fn figures(&self) -> Result<Vec<(String, String)>, Failure> {
        Ok(vec![
            ("fig-18.svg".into(), values(self.seed, true)),
            ("fig-19.svg".into(), values(self.seed, false)),
        ])
    }
}

/// The values of the decision process on the world of a seed, with a goal or without.
pub fn values(seed: u64, has_goal: bool) -> String {
    let world = monte_carlo_of(FIGURE_SIDE, seed);
    let goal = has_goal.then(|| goal_cell(&world));
    let words = if has_goal { "with" } else { "without" };
    FieldMap {
        title: format!("Value of entropy as a reward, {words} a goal"),
        caption: format!("{FIGURE_SIDE} × {FIGURE_SIDE} cells, seed {seed}; dark is impassable"),
        quantity: "value [bits]".into(),
        columns: FIGURE_SIDE,
        cell_m: 1.0,
        values: GridMdp::new(&world.prior, goal).solve(TOLERANCE).values,
        ways: Vec::new(),
    }
    .svg()
}
