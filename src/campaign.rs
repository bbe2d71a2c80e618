//! `hopper campaign`: a grid of missions flown in lockstep on all cores, and what they come to.

pub mod fly;
pub mod merge;
mod progress;
mod regret;
pub mod report;
pub mod rerun;
pub mod store;

use std::io::{self, ErrorKind, Write};

use node::{Exit, Failure};

/// Tools for campaigns.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Fly a campaign, or a shard of one, one row a trial.
    Run(fly::Args),
    /// Put the shards of a campaign together.
    Merge(merge::Args),
    /// Say what a campaign comes to, cell by cell.
    Report(report::Args),
    /// Fly one trial again, with picture and journal, and check its digest.
    Rerun(rerun::Args),
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 for a campaign, a folder or a flag at fault; 1 if files cannot be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Run(args) => fly::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Report(args) => report::run(args),
        Command::Rerun(args) => rerun::run(args),
    }
}

/// Writes data to standard output; a reader who has seen enough is no error.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written?),
    }
}
