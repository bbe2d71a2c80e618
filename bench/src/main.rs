//! The solver's side of the comparison with other solvers; `bench/run` is its one caller.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use serde_json::json;
use solver::fixtures::Fixture;
use solver::{Effort, Solution, Solver};

use crate::rows::Rows;

mod risk;
mod rows;
mod stopwatch;

/// Worlds for other solvers, and Hopper's own times on them.
#[derive(Debug, Parser)]
struct Options {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Write a world as the rows of a Markov decision process.
    Export(WorldArgs),
    /// Solve a world, write its values, print times and memory as JSON.
    Solve(Solve),
    /// Plan with bounds on the risk, write the world, print the plans as JSON.
    Risk(risk::Risk),
}

/// The world, and the folder of its files.
#[derive(Debug, clap::Args)]
struct WorldArgs {
    /// Kind of world to build.
    kind: WorldKind,
    /// Nodes per side of the square world.
    side: usize,
    /// Folder of the world's files.
    folder: PathBuf,
    /// Seed of the world.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Bound on |V − V*| to reach, in units of payoff.
    #[arg(long, default_value_t = 1e-6)]
    error_max: f64,
}

/// Options of a solve.
#[derive(Debug, clap::Args)]
struct Solve {
    #[command(flatten)]
    world: WorldArgs,
    /// Threads, 1 or 2; the values of 2 go to hopper-2.f64.
    #[arg(long, default_value_t = 1, conflicts_with = "kept")]
    threads: usize,
    /// Solve with one solver, which keeps its buffers; the values go to hopper-kept.f64.
    #[arg(long)]
    kept: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum WorldKind {
    /// The goal is worth reaching.
    Plain,
    /// The goal is worth reaching, and lies well inside the map.
    Inner,
    /// Lingering on a hill pays more than the goal.
    Trap,
    /// The ground of `plain`, where hops land by a table of twelve landings.
    Table,
    /// The ground of `inner`, where hops land by a table of twelve landings.
    InnerTable,
}

fn main() -> ExitCode {
    let done = match Options::parse().task {
        Task::Export(args) => export(&args),
        Task::Solve(args) => solve(&args),
        Task::Risk(args) => risk::plan(&args).map(|plans| print(&plans)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print_error(error.as_ref());
            ExitCode::FAILURE
        }
    }
}

#[allow(clippy::print_stderr, reason = "the one place where errors leave")]
fn print_error(error: &dyn Error) {
    eprintln!("bench: {error}");
}

fn fixture(args: &WorldArgs) -> Fixture {
    match args.kind {
        WorldKind::Plain | WorldKind::Table => Fixture::plain(args.side, args.seed),
        WorldKind::Inner | WorldKind::InnerTable => Fixture::inner(args.side, args.seed),
        WorldKind::Trap => Fixture::trap(args.side, args.seed),
    }
}

impl WorldKind {
    fn has_table(self) -> bool {
        matches!(self, Self::Table | Self::InnerTable)
    }
}

fn export(args: &WorldArgs) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(&args.folder)?;
    let rows = if args.kind.has_table() {
        Rows::of_table(&fixture(args).table_world()?)
    } else {
        Rows::of(&fixture(args).world()?)
    };
    rows.write(&args.folder)?;
    let header = json!({
        "states": rows.nodes.len(),
        "rows": rows.rewards.len(),
        "landings": rows.landings,
        "discount": solver::fixtures::DISCOUNT,
        "error_max": args.error_max,
    });
    Ok(std::fs::write(args.folder.join("world.json"), format!("{header:#}\n"))?)
}

/// Solves a world whose hops land by a table.
fn solve_table(args: &WorldArgs) -> Result<(), Box<dyn Error>> {
    let world = fixture(args).table_world()?;
    let peak_before = stopwatch::peak_bytes();
    let effort = Effort { error_max: args.error_max, ..Effort::default() };
    let (times, (values, solution)) = stopwatch::repeat(false, |_| solver::landings::solve(&world, &effort));
    let peak = stopwatch::peak_bytes();
    write_values(&args.folder.join("hopper.f64"), &Rows::of_table(&world), &values)?;
    report(times, [peak, peak_before], &solution);
    Ok(())
}

fn solve(task: &Solve) -> Result<(), Box<dyn Error>> {
    let args = &task.world;
    if args.kind.has_table() {
        return solve_table(args);
    }
    let world = fixture(args).world()?;
    let peak_before = stopwatch::peak_bytes();
    let effort = Effort { error_max: args.error_max, ..Effort::default() };
    let (times, (solver, solution)) = stopwatch::repeat(task.kept, |before: Option<(Solver, Solution)>| {
        let new = || Solver::new().with_threads(task.threads);
        let mut solver = before.map_or_else(new, |(solver, _)| solver);
        let solution = solver.solve(&world, &effort);
        (solver, solution)
    });
    let peak = stopwatch::peak_bytes();
    let file = match (task.kept, task.threads) {
        (true, _) => "hopper-kept.f64",
        (false, 1) => "hopper.f64",
        (false, _) => "hopper-2.f64",
    };
    write_values(&args.folder.join(file), &Rows::of(&world), solver.values())?;
    report(times, [peak, peak_before], &solution);
    Ok(())
}

/// Prints what a solve took, and how good it is.
fn report(times: stopwatch::Times, [peak, peak_before]: [Option<u64>; 2], solution: &Solution) {
    print(&json!({
        "times": times,
        "peak_bytes": peak,
        "peak_before_solve_bytes": peak_before,
        "error_bound": solution.certificate.error_bound,
        "sweeps": solution.sweeps,
    }));
}

fn write_values(file: &Path, rows: &Rows, values: &[f64]) -> Result<(), Box<dyn Error>> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    Ok(rows::write(file, rows.values(values).map(f64::to_le_bytes))?)
}

#[allow(clippy::print_stdout, reason = "a benchmark's output is its data")]
fn print(answer: &serde_json::Value) {
    println!("{answer}");
}
