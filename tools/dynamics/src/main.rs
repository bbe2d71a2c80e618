//! `hopper-dynamics`: serves `hopper motion` and `hopper validate`.

use std::process::ExitCode;

use clap::Parser;

#[derive(Parser)]
#[command(name = "hopper", bin_name = "hopper", version = hopper::VERSION)]
struct Cli {
    #[command(subcommand)]
    command: hopper_dynamics::Command,
}

fn main() -> ExitCode {
    let cli: Cli = hopper::command_line::parse();
    hopper::tool::main("hopper", || hopper_dynamics::run(&cli.command))
}
