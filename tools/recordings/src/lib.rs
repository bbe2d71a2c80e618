//! Commands that read recordings, which `hopper run --record` and `hopper monitor --record` make.

pub mod bag;
pub mod latency;
pub mod view;

use clap::Subcommand;
use hopper::progress::while_working;
use node::{Exit, Failure};

/// The commands of `hopper` that this package serves.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Inspect, recover, replay or export a recording.
    #[command(
        subcommand,
        after_help = "Examples:\n  hopper bag info hard.mcap\n  hopper bag recover cut.mcap whole.mcap\n  hopper bag replay hard.mcap --planner greedy\n  hopper bag export hard.mcap > decisions.csv"
    )]
    Bag(bag::Command),
    /// Report where the time of decisions went, and why the longest took so long.
    #[command(
        subcommand,
        after_help = "Examples:\n  hopper latency report hard.mcap --budget 600ms\n  hopper latency report --instance hopper\n  hopper latency report --compare a.mcap b.mcap"
    )]
    Latency(latency::Command),
    /// Show a recording in a browser.
    #[command(hide = true)]
    View(view::Args),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        // Who steps by hand knows how long it takes.
        Command::Bag(command) if command.is_by_hand() => bag::run(command),
        Command::Bag(command) => while_working("reading the recording", || bag::run(command)),
        Command::Latency(command) => latency::run(command),
        Command::View(args) => view::run(args),
    }
}
