//! `hopper-figures`: serves `hopper gif`, and turns pictures into PDF.

use std::process::ExitCode;

use clap::Parser;

#[derive(Parser)]
#[command(name = "hopper", bin_name = "hopper", version = hopper::VERSION)]
struct Cli {
    #[command(subcommand)]
    command: hopper_figures::Command,
}

fn main() -> ExitCode {
    let cli: Cli = hopper::command_line::parse();
    hopper::tool::main("hopper", || hopper_figures::run(&cli.command))
}
