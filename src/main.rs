//! `hopper`: every process and every tool of the stack in one executable.

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use hopper::{
    bag, campaign, chaos, doctor, endure, gallery, journal, known, latency, manual, run, scenario, simulate,
    terrain, topic,
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
  hopper run --web --control --pace 2           watch and control it on a page: the log tells its address
  hopper monitor --tui                          watch a running mission on this terminal
  hopper campaign run campaigns/p23-tables.toml the paper's tables, 3,000 missions
  hopper known findings --out out/known         the known-ground paper's findings, with its figures
  hopper run --record hard.mcap                 every message in a file; see hopper bag, hopper latency
  hopper doctor                                 what runs, what is missing, what to do next

Exit codes: 0 done, 1 mission failed or run error, 2 usage or bad input, 3 threshold missed,
4 peer missing or incompatible, 130 interrupted.";

#[derive(Subcommand)]
enum Command {
    /// Fly a mission: start the four processes, watch over them, sum up.
    #[command(
        after_help = "Examples:\n  hopper run --scenario sandy --profile hopper --seed 3\n  hopper run --pace 5 --web --control\n  hopper run --lockstep --format json"
    )]
    Run(Box<run::Args>),
    /// The simulator process: executes hops, arbitrates who commands, keeps the journal.
    #[command(
        after_help = "Examples:\n  hopper sim --scenario hard --seed 7 --pace 2 --journal out/j\n  hopper sim --journal out/j --control"
    )]
    Sim(hopper_sim::shell::Args),
    /// The perception process: senses at every landing and serves the observed map.
    #[command(
        after_help = "Examples:\n  hopper perception\n  hopper perception --instance mine --wait 30s --stay"
    )]
    Perception(perception::shell::Args),
    /// A planner process: decides the next hop, or stands by.
    #[command(after_help = "Examples:\n  hopper planner\n  hopper planner --algorithm greedy --takeover")]
    Planner(planner::shell::Args),
    /// The monitor process: watches latency and health.
    #[command(
        after_help = "Examples:\n  hopper monitor --web\n  hopper monitor --web 127.0.0.1:9000 --control\n  hopper monitor --tui"
    )]
    Monitor(monitor::shell::Args),
    /// Fly a grid of missions on all cores, and say what they come to.
    #[command(subcommand)]
    #[command(
        after_help = "Examples:\n  hopper campaign run campaigns/p23-tables.toml\n  hopper campaign report out/p23-tables --against paper"
    )]
    Campaign(campaign::Command),
    /// Draw the figures of docs/gallery.md again.
    #[command(after_help = "Examples:\n  hopper gallery")]
    Gallery(gallery::Args),
    /// Simulate the whole system in one thread, with everything going wrong that may.
    #[command(after_help = "Examples:\n  hopper simulate --seeds 0..2000")]
    Simulate(simulate::Args),
    /// Fly a long patrol through four processes, kill them in turn, and see whether anything grows.
    #[command(
        after_help = "Examples:\n  hopper endure --hops 20000 --kill-every 2000\n  hopper endure --scenario patrol --hops 5000 --kill-every 0 --format json"
    )]
    Endure(endure::Args),
    /// Kill, stop and restart real processes of real missions, and count what it does to them.
    #[command(
        after_help = "Examples:\n  hopper chaos --faults 20\n  hopper chaos --role planner --format json"
    )]
    Chaos(chaos::Args),
    /// Plan on ground known from edge to edge, as the predecessor paper did.
    #[command(subcommand)]
    #[command(after_help = "Examples:\n  hopper known findings --out out/known")]
    Known(known::Command),
    /// Check a scenario, or print the schema of scenarios.
    #[command(subcommand)]
    #[command(after_help = "Examples:\n  hopper scenario check my.toml\n  hopper scenario schema")]
    Scenario(scenario::Command),
    /// Check an elevation model.
    #[command(subcommand)]
    #[command(after_help = "Examples:\n  hopper terrain check dem.tif")]
    Terrain(terrain::Command),
    /// Verify or show a journal.
    #[command(subcommand)]
    #[command(
        after_help = "Examples:\n  hopper journal verify out/hard-1/journal\n  hopper journal show out/hard-1/journal"
    )]
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
    #[command(
        after_help = "Examples:\n  hopper topic list\n  hopper topic echo state --format json\n  hopper topic hz heartbeat"
    )]
    Topic(topic::Command),
    /// What runs, what is missing, what is left over, and what to do next.
    #[command(after_help = "Examples:\n  hopper doctor\n  hopper doctor --clean")]
    Doctor(doctor::Args),
    /// Print the completions of a shell.
    Completions(manual::Completions),
    /// Print the manual page, or write those of all commands to a folder.
    Man(manual::Man),
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
        Command::Completions(args) => manual::completions(args, Cli::command()),
        Command::Man(args) => manual::man(args, Cli::command()),
        _ => unreachable!("processes are started by main"),
    }
}
