//! Quality rigs: faults injected into real and simulated processes, and long runs.

pub mod chaos;
pub mod endure;
pub mod fuzz;
pub mod planted;
pub mod simulate;

use clap::Subcommand;
use node::{Exit, Failure};

/// The commands of `hopper` that this package serves.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Simulate the whole system in one thread while faults are injected.
    #[command(after_help = "Examples:\n  hopper simulate --seeds 0..2000")]
    Simulate(simulate::Args),
    /// Kill, stop and restart real processes of real missions, and count the effects.
    #[command(
        after_help = "Examples:\n  hopper chaos --faults 20\n  hopper chaos --role planner --format json\n  hopper chaos --scenario coverage-8 --after 300 --faults 5"
    )]
    Chaos(chaos::Args),
    /// Fly a long patrol, or a mission of several robots, kill its processes in turn, and check that nothing grows.
    #[command(
        after_help = "Examples:\n  hopper endure --hops 20000 --kill-every 2000\n  hopper endure --scenario patrol --hops 5000 --kill-every 0 --format json"
    )]
    Endure(endure::Args),
    /// Fly random missions of all kinds in lockstep, with simulated faults, and by real processes that are killed.
    #[command(
        after_help = "Examples:\n  hopper-qa fuzz-missions\n  hopper-qa fuzz-missions --seeds 0..1000 --kind mixed --live 0"
    )]
    FuzzMissions(fuzz::Args),
    /// Plant bugs in a copy of the sources, and check that the simulation finds each.
    #[command(
        after_help = "Examples:\n  hopper-qa planted\n  hopper-qa planted --only torn-tail-kept --format json"
    )]
    Planted(planted::Args),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Simulate(args) => simulate::run(args),
        Command::Chaos(args) => chaos::run(args),
        Command::Endure(args) => endure::run(args),
        Command::FuzzMissions(args) => fuzz::run(args),
        Command::Planted(args) => planted::run(args),
    }
}
