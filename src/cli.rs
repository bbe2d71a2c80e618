//! The command line of `hopper`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use node::{Exit, Failure};

use crate::command_line;
use crate::commands::{campaign, doctor, journal, run, scenario, terrain, topic, view};
use crate::progress::while_working;
use crate::tool::{self, Passed};

/// Autonomy stack and simulator for planetary hopping robots.
///
/// Without a command this is `hopper run`: four processes cross the hard ground of Sakamoto & Kunii 2023.
#[derive(Parser)]
#[command(name = "hopper", version = crate::VERSION, after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: run::Args,
}

const EXAMPLES: &str = "\
Examples:
  hopper                                        the default mission
  hopper run --scenario sandy --profile hopper  another mission; hopper scenario list has more
  hopper run --dem dem.tif                      a mission over your own elevation model
  hopper run --lockstep --format json           the same mission in one thread
  hopper planner --algorithm greedy --takeover  replace the planner of a running mission
  hopper run --web --control --pace 2           watch and control it in a browser: the log shows the address
  hopper view out/hard-1 --open                 look at a past mission in a browser
  hopper monitor --tui                          watch a running mission in this terminal
  hopper campaign run p23-tables                the paper's tables, 3,000 missions
  hopper run --record hard.mcap                 record every message; see hopper bag, hopper latency
  hopper doctor                                 what runs, what is missing, what to do next

Commands in brackets are programs of their own: cargo build --release builds them all.

Exit codes: 0 done, 1 mission failed or run error, 2 usage or bad input, 3 threshold missed,
4 peer missing or incompatible, 130 interrupted.";

#[derive(Subcommand)]
enum Command {
    /// Fly a mission: start the four processes, supervise them, print a summary.
    #[command(
        after_help = "Examples:\n  hopper run --scenario sandy --profile hopper --seed 3\n  hopper run --pace 5 --web --control\n  hopper run --lockstep --format json"
    )]
    Run(Box<run::Args>),
    /// The simulator process: executes hops, decides whose commands count, keeps the journal.
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
    /// Show a past mission in a browser: a journal, the output folder of a run, or a recording.
    #[command(after_help = "Examples:\n  hopper view out/hard-1 --open\n  hopper view hard.mcap --web 9000")]
    View(view::Args),
    /// Fly a grid of missions on all cores, and report the results.
    #[command(subcommand)]
    #[command(
        after_help = "Examples:\n  hopper campaign list\n  hopper campaign run p23-tables\n  hopper campaign report out/p23-tables --against paper"
    )]
    Campaign(campaign::Command),
    /// List the built-in scenarios, make or check one, or print the schema of scenarios.
    #[command(subcommand)]
    #[command(
        after_help = "Examples:\n  hopper scenario list\n  hopper scenario new --dem dem.tif --out my.toml\n  hopper scenario check my.toml\n  hopper scenario schema"
    )]
    Scenario(scenario::Command),
    /// Check an elevation model.
    #[command(subcommand)]
    #[command(after_help = "Examples:\n  hopper terrain check dem.tif")]
    Terrain(terrain::Command),
    /// Verify, show or draw a journal.
    #[command(subcommand)]
    #[command(
        after_help = "Examples:\n  hopper journal verify out/hard-1\n  hopper journal show out/hard-1\n  hopper journal draw out/hard-1 --picture paper --out hard.pdf"
    )]
    Journal(journal::Command),
    /// List, echo or measure the messages of a running instance.
    #[command(subcommand)]
    #[command(
        after_help = "Examples:\n  hopper topic list\n  hopper topic echo state --format json\n  hopper topic hz heartbeat"
    )]
    Topic(topic::Command),
    /// Show what runs, what is missing or left over, and what to do next.
    #[command(after_help = "Examples:\n  hopper doctor\n  hopper doctor --clean")]
    Doctor(doctor::Args),
    /// [hopper-dynamics] Derive what planners may believe of hops from physics.
    #[command(disable_help_flag = true)]
    Motion(Passed),
    /// [hopper-dynamics] Compare contact dynamics with closed forms and with what has been measured and flown.
    #[command(disable_help_flag = true)]
    Validate(Passed),
    /// [hopper-figures] Write an animation of a mission.
    #[command(disable_help_flag = true)]
    Gif(Passed),
    /// [hopper-recordings] Inspect, recover, replay or export a recording.
    #[command(disable_help_flag = true)]
    Bag(Passed),
    /// [hopper-link] Send telemetry of a mission to the ground as CCSDS space packets, and describe them in XTCE.
    #[command(disable_help_flag = true)]
    Link(Passed),
    /// [hopper-recordings] Report where the time of decisions went, and why the longest took so long.
    #[command(disable_help_flag = true)]
    Latency(Passed),
    /// [hopper-research] Cover unknown ground with rovers that see their neighbouring cells.
    #[command(disable_help_flag = true)]
    Coverage(Passed),
    /// [hopper-research] Plan on fully known ground, as the predecessor paper did.
    #[command(disable_help_flag = true)]
    Known(Passed),
    /// [hopper-research] Draw the figures of docs/gallery.md again.
    #[command(disable_help_flag = true)]
    Gallery(Passed),
    /// [hopper-research] Drive a rover on uncertain ground, with and without a helicopter.
    #[command(disable_help_flag = true)]
    Scouting(Passed),
    /// [hopper-qa] Simulate the whole system in one thread while faults are injected.
    #[command(disable_help_flag = true)]
    Simulate(Passed),
    /// [hopper-qa] Kill, stop and restart real processes of real missions, and count the effects.
    #[command(disable_help_flag = true)]
    Chaos(Passed),
    /// [hopper-qa] Fly a long mission, kill its processes in turn, and check that nothing grows.
    #[command(disable_help_flag = true)]
    Endure(Passed),
    /// [hopper-manual] Print the completions for a shell.
    #[command(disable_help_flag = true)]
    Completions(Passed),
    /// [hopper-manual] Print the manual page, or write those of all commands to a folder.
    #[command(disable_help_flag = true)]
    Man(Passed),
}

/// Parses the command line and runs the command.
#[must_use]
pub fn main() -> ExitCode {
    if let Some((program, words)) = tool::help(std::env::args_os().skip(1)) {
        return node::main("hopper", || tool::exec(program, words));
    }
    let cli: Cli = command_line::parse();
    match cli.command {
        None => node::main("hopper", || run::run(&cli.run)),
        Some(Command::Run(args)) => node::main("hopper", || run::run(&args)),
        Some(Command::Sim(args)) => node::main("hopper-sim", || hopper_sim::shell::run(&args)),
        Some(Command::Perception(args)) => node::main("perception", || perception::shell::run(&args)),
        Some(Command::Planner(args)) => node::main("planner", || planner::shell::run(&args)),
        Some(Command::Monitor(args)) => node::main("monitor", || watch(&args)),
        Some(command) => node::main("hopper", || tool(&command)),
    }
}

/// The terminal view and the recorder are linked into another program, which gets the same arguments.
fn watch(args: &monitor::shell::Args) -> Result<Exit, Failure> {
    if args.need_extensions() {
        tool::exec("hopper-view", std::env::args_os().skip(1))
    } else {
        monitor::shell::run(args, &monitor::shell::Extensions::default())
    }
}

fn tool(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Campaign(command) => campaign::run(command),
        Command::Scenario(command) => while_working("reading the ground", || scenario::run(command)),
        Command::Terrain(command) => while_working("reading the ground", || terrain::run(command)),
        Command::View(args) => view::run(args),
        Command::Journal(command) => while_working("reading the journal", || journal::run(command)),
        Command::Topic(command) => topic::run(command),
        Command::Doctor(args) => doctor::run(args),
        Command::Motion(passed) => tool::run("motion", passed),
        Command::Validate(passed) => tool::run("validate", passed),
        Command::Gif(passed) => tool::run("gif", passed),
        Command::Bag(passed) => tool::run("bag", passed),
        Command::Link(passed) => tool::run("link", passed),
        Command::Latency(passed) => tool::run("latency", passed),
        Command::Coverage(passed) => tool::run("coverage", passed),
        Command::Known(passed) => tool::run("known", passed),
        Command::Gallery(passed) => tool::run("gallery", passed),
        Command::Scouting(passed) => tool::run("scouting", passed),
        Command::Simulate(passed) => tool::run("simulate", passed),
        Command::Chaos(passed) => tool::run("chaos", passed),
        Command::Endure(passed) => tool::run("endure", passed),
        Command::Completions(passed) => tool::run("completions", passed),
        Command::Man(passed) => tool::run("man", passed),
        _ => unreachable!("processes are started by main"),
    }
}
