//! `monitor`: watches latency and health; the same as `hopper monitor`.

use std::process::ExitCode;

use clap::Parser;

/// Monitor of a planetary hopper: watches every public message.
#[derive(Parser)]
#[command(version, after_help = "Examples:\n  monitor --web\n  monitor --web 127.0.0.1:9000 --control")]
struct Cli {
    #[command(flatten)]
    args: monitor::shell::Args,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    node::main("monitor", || monitor::shell::run(&cli.args, &monitor::shell::Extensions::default()))
}
