//! `hopper known`: repeats Sakamoto & Kubota 2022, which plans on fully known ground.

pub mod findings;
pub mod plan;
pub mod search;

use node::{Exit, Failure};

/// Planning on fully known ground.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Repeat every plan of the paper, and report which of its claims hold.
    #[command(after_help = "Examples:\n  hopper known findings\n  hopper known findings --out out/known")]
    Findings(findings::Args),
    /// Plan one experiment at one weight: policy, path, and the ground along it.
    #[command(
        after_help = "Examples:\n  hopper known plan hard\n  hopper known plan rocks --w1 0.7 --out out/rocks"
    )]
    Plan(plan::Args),
    /// Search for the reading of what the paper leaves open that reproduces most of it; takes minutes.
    #[command(
        after_help = "Examples:\n  hopper known search\n  hopper known search --samples 100 --climbs 3 --format json"
    )]
    Search(search::Args),
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 for a wrong flag; 1 if files cannot be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Findings(args) => findings::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Search(args) => search::run(args),
    }
}
