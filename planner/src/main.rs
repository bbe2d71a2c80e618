//! `planner`: decides the next hop; the same as `hopper planner`.

use std::process::ExitCode;

use clap::Parser;

/// Planner of a planetary hopper: decides the next hop, or stands by.
#[derive(Parser)]
#[command(version, after_help = "Examples:\n  planner\n  planner --algorithm greedy --takeover")]
struct Cli {
    #[command(flatten)]
    args: planner::shell::Args,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    node::main("planner", || planner::shell::run(&cli.args))
}
