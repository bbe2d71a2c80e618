//! Quality rigs that run real missions: faults injected into processes, and long runs.

pub mod chaos;
pub mod endure;

use clap::Subcommand;
use node::{Exit, Failure};

/// The commands of `hopper` that this package serves.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Kill, stop and restart real processes of real missions, and count the effects.
    #[command(
        after_help = "Examples:\n  hopper chaos --faults 20\n  hopper chaos --role planner --format json"
    )]
    Chaos(chaos::Args),
    /// Fly a long patrol, kill its processes in turn, and check that nothing grows.
    #[command(
        after_help = "Examples:\n  hopper endure --hops 20000 --kill-every 2000\n  hopper endure --scenario patrol --hops 5000 --kill-every 0 --format json"
    )]
    Endure(endure::Args),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Chaos(args) => chaos::run(args),
        Command::Endure(args) => endure::run(args),
    }
}
