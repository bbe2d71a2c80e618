//! `hopper-qa`: serves `hopper chaos`, `hopper endure` and `hopper simulate`, and plants bugs.

use std::process::ExitCode;

use clap::Parser;

#[derive(Parser)]
#[command(name = "hopper", bin_name = "hopper", version = hopper::VERSION)]
struct Cli {
    #[command(subcommand)]
    command: hopper_qa::Command,
}

fn main() -> ExitCode {
    let cli: Cli = hopper::command_line::parse();
    hopper::tool::main("hopper", || hopper_qa::run(&cli.command))
}
