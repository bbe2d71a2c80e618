//! `hopper-research`: serves `hopper coverage`, `hopper gallery`, `hopper known` and `hopper scouting`, and `hopper campaign` for
//! campaigns that name a study.

use std::process::ExitCode;

use clap::Parser;

#[derive(Parser)]
#[command(name = "hopper", bin_name = "hopper", version = hopper::VERSION)]
struct Cli {
    #[command(subcommand)]
    command: hopper_research::Command,
}

fn main() -> ExitCode {
    let cli: Cli = hopper::command_line::parse();
    hopper::tool::main("hopper", || hopper_research::run(&cli.command))
}
