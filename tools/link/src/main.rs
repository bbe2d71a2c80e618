//! `hopper-link`: serves `hopper link`.

mod observer;
mod shell;
mod transport;

use std::process::ExitCode;

use clap::Parser;

#[derive(Parser)]
#[command(name = "hopper", bin_name = "hopper", version = hopper::VERSION)]
enum Cli {
    /// The link to the ground: sends telemetry of a mission as CCSDS space packets.
    #[command(
        args_conflicts_with_subcommands = true,
        after_help = "Examples:\n  hopper link                              to UDP port 10015 of this machine\n  \
                      hopper link --tcp 10016 --rate 2000      to whoever connects, 2,000 bit/s of mission time\n  \
                      hopper link xtce > hopper.xml            what the packets consist of, for mission control software"
    )]
    Link(shell::Args),
}

fn main() -> ExitCode {
    let Cli::Link(args) = hopper::command_line::parse();
    hopper::tool::main("link", || shell::run(&args))
}
