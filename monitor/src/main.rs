//! `monitor`: watches latency and health; the same as `hopper monitor`.

use std::process::ExitCode;

use clap::Parser;

/// Monitor of a planetary hopper: watches every public message.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: monitor::shell::Args,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    node::main("monitor", || monitor::shell::run(&cli.args, &monitor::shell::Extensions::default()))
}
