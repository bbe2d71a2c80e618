//! `hopper`: every process and every tool of the stack in one executable.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hopper::{
    bag, campaign, chaos, doctor, endure, gallery, journal, known, latency, run, scenario, simulate, terrain,
    topic,
};
use node::{Exit, Failure};

/// Autonomy stack and simulator for planetary hopping robots.
///
/// Without a command this is `hopper run`: four processes cross the hard ground of Sakamoto & Kunii 2023.
#[derive(Parser)]
#[command(version = concat!(env!("CARGO_PKG_VERSION"), " (", env!("HOPPER_COMMIT"), ")"), after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: run::Args,
}

const EXAMPLES: &str = "\
Examples:
  hopper                                        the main job, with its defaults
  hopper run --scenario sandy --profile hopper  another mission
  hopper run --lockstep --format json           the same machines in one thread
  hopper planner --algorithm greedy --takeover  swap the planner of a running mission
  hopper campaign run campaigns/p23-tables.toml the paper's tables, 3,000 missions
  hopper known findings --out out/known         the known-ground paper's findings, with its figures
  hopper run --record hard.mcap                 every message in a file; see hopper bag, hopper latency
  hopper doctor                                 what runs, what is missing, what to do next

Exit codes: 0 done, 1 mission failed or run error, 2 usage or bad input, 3 threshold missed,
4 peer missing or incompatible, 130 interrupted.";

#[derive(Subcommand)]
enum Command {
    /// Fly a mission: start the four processes, watch over them, sum up.
    Run(Box<run::Args>),
    /// The simulator process: executes hops, arbitrates who commands, keeps the journal.
    Sim(hopper_sim::shell::Args),
    /// The perception process: senses at every landing and serves the observed map.
    Perception(perception::shell::Args),
    /// A planner process: decides the next hop, or stands by.
    Planner(planner::shell::Args),
    /// The monitor process: watches latency and health.
    Monitor(monitor::shell::Args),
    /// Fly a grid of missions on all cores, and say what they come to.
    #[command(subcommand)]
    Campaign(campaign::Command),
    /// Draw the figures of docs/gallery.md again.
    Gallery(gallery::Args),
    /// Simulate the whole system in one thread, with everything going wrong that may.
    Simulate(simulate::Args),
    /// Fly a long patrol through four processes, kill them in turn, and see whether anything grows.
    Endure(endure::Args),
    /// Kill, stop and restart real processes of real missions, and count what it does to them.
    Chaos(chaos::Args),
    /// Plan on ground known from edge to edge, as the predecessor paper did.
    #[command(subcommand)]
    Known(known::Command),
    /// Check a scenario, or print the schema of scenarios.
    #[command(subcommand)]
    Scenario(scenario::Command),
    /// Check an elevation model.
    #[command(subcommand)]
    Terrain(terrain::Command),
    /// Verify or show a journal.
    #[command(subcommand)]
    Journal(journal::Command),
    /// Look into, recover, replay or export a recording.
    #[command(
        subcommand,
        after_help = "Examples:\n  hopper bag info hard.mcap\n  hopper bag recover cut.mcap whole.mcap\n  hopper bag replay hard.mcap --planner greedy\n  hopper bag export hard.mcap > decisions.csv"
    )]
    Bag(bag::Command),
    /// Tell where the time of decisions went, and why the longest were long.
    #[command(
        subcommand,
        after_help = "Examples:\n  hopper latency report hard.mcap --budget 600ms\n  hopper latency report --instance hopper\n  hopper latency report --compare a.mcap b.mcap"
    )]
    Latency(latency::Command),
    /// List, echo or measure the messages of a running instance.
    #[command(subcommand)]
    Topic(topic::Command),
    /// What runs, what is missing, what is left over, and what to do next.
    Doctor(doctor::Args),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    match cli.command {
        None => node::main("hopper", || run::run(&cli.run)),
        Some(Command::Run(args)) => node::main("hopper", || run::run(&args)),
        Some(Command::Sim(args)) => node::main("hopper-sim", || hopper_sim::shell::run(&args)),
        Some(Command::Perception(args)) => node::main("perception", || perception::shell::run(&args)),
        Some(Command::Planner(args)) => node::main("planner", || planner::shell::run(&args)),
        Some(Command::Monitor(args)) => node::main("monitor", || monitor::shell::run(&args)),
        Some(command) => node::main("hopper", || tool(&command)),
    }
}

fn tool(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Campaign(command) => campaign::run(command),
        Command::Gallery(args) => gallery::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Endure(args) => endure::run(args),
        Command::Chaos(args) => chaos::run(args),
        Command::Known(command) => known::run(command),
        Command::Scenario(command) => scenario::run(command),
        Command::Terrain(command) => terrain::run(command),
        Command::Journal(command) => journal::run(command),
        Command::Bag(command) => bag::run(command),
        Command::Latency(command) => latency::run(command),
        Command::Topic(command) => topic::run(command),
        Command::Doctor(args) => doctor::run(args),
        _ => unreachable!("processes are started by main"),
    }
}
