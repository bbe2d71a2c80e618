//! `hopper-sim`: executes hops and keeps the journal; the same as `hopper sim`.

use std::process::ExitCode;

use clap::Parser;

/// Simulator of a planetary hopper: executes hops, arbitrates who commands, keeps the journal.
#[derive(Parser)]
#[command(version, after_help = "Examples:\n  hopper-sim --scenario hard --seed 7 --pace 2 --journal out/j")]
struct Cli {
    #[command(flatten)]
    args: hopper_sim::shell::Args,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    node::main("hopper-sim", || hopper_sim::shell::run(&cli.args))
}
