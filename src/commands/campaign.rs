//! `hopper campaign`: flies a grid of missions in lockstep on all cores, and reports the results.

pub mod fly;
pub mod merge;
mod progress;
mod regret;
pub mod report;
pub mod rerun;
pub mod store;

use node::{Exit, Failure};

/// Subcommands of `hopper campaign`.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Fly a campaign, or a shard of one, one row a trial.
    Run(fly::Args),
    /// Merge the shards of a campaign.
    Merge(merge::Args),
    /// Report the results of a campaign, cell by cell.
    Report(report::Args),
    /// Fly one trial again, with picture and journal, and check its digest.
    Rerun(rerun::Args),
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 for a wrong campaign, folder or flag; 1 if files cannot be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Run(args) => fly::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Report(args) => report::run(args),
        Command::Rerun(args) => rerun::run(args),
    }
}
