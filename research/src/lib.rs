//! Commands that reproduce published results: what the papers report, and their figures.

pub mod campaign;
pub mod claims;
pub mod coverage;
mod form;
pub mod gallery;
pub mod known;
pub mod report;
pub mod reported;
pub mod scouting;
pub mod studies;

use clap::Subcommand;
use hopper::progress::while_working;
use node::{Exit, Failure};

/// The commands of `hopper` that this package serves.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Fly, merge, report or rerun a campaign that names a study. `hopper campaign` hands those to this program.
    #[command(subcommand, hide = true)]
    Campaign(hopper::commands::campaign::Command),
    /// Cover unknown ground with rovers that see their neighbouring cells, and check the paper's claims.
    #[command(after_help = "Examples:\n  hopper coverage --runs 300\n  hopper coverage --out out/coverage")]
    Coverage(coverage::Args),
    /// Draw the figures of docs/gallery.md again.
    #[command(after_help = "Examples:\n  hopper gallery")]
    Gallery(gallery::Args),
    /// Plan on fully known ground, as the predecessor paper did.
    #[command(subcommand)]
    #[command(after_help = "Examples:\n  hopper known findings --out out/known")]
    Known(known::Command),
    /// Drive a rover on uncertain ground, with and without a helicopter, as Folsom et al. 2021 did.
    #[command(
        after_help = "Examples:\n  hopper scouting --runs 100\n  hopper scouting --rover ett_exact --format json"
    )]
    Scouting(scouting::Args),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Campaign(command) => campaign::run(command),
        Command::Coverage(args) => while_working("covering ground", || coverage::run(args)),
        Command::Gallery(args) => while_working("drawing the gallery", || gallery::run(args)),
        Command::Known(command) => while_working("planning on known ground", || known::run(command)),
        Command::Scouting(args) => while_working("driving and flying", || scouting::run(args)),
    }
}
