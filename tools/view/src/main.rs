//! `hopper-view`: serves `hopper monitor --tui`, `hopper monitor --record` and `hopper monitor --foxglove`.

use std::process::ExitCode;

use clap::Parser;
use monitor::shell::Extensions;

#[derive(Parser)]
#[command(name = "hopper", bin_name = "hopper", version = hopper::VERSION)]
enum Cli {
    /// The monitor process: watches latency and health.
    Monitor(monitor::shell::Args),
}

fn main() -> ExitCode {
    let Cli::Monitor(args) = hopper::command_line::parse();
    let extensions = Extensions {
        terminal: Some(terminal::open),
        recorder: Some(recorder::open),
        foxglove: Some(foxglove_server::open),
    };
    hopper::tool::main("monitor", || monitor::shell::run(&args, &extensions))
}
