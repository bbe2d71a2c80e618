//! `perception`: builds the observed map; the same as `hopper perception`.

use std::process::ExitCode;

use clap::Parser;

/// Perception of a planetary hopper: senses at every landing and serves the observed map.
#[derive(Parser)]
#[command(version, after_help = "Examples:\n  perception --instance mine --wait 30s --stay")]
struct Cli {
    #[command(flatten)]
    args: perception::shell::Args,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    node::main("perception", || perception::shell::run(&cli.args))
}
