//! `hopper campaign`: flies the trials of a campaign on all cores, and reports the results.
//!
//! Campaigns of missions are flown in lockstep by this program. A campaign that names a study is handed to
//! `hopper-research`, which links what the studies need; folders, shards, merging and the command line are those of here.

mod built_in;
pub mod fly;
pub mod merge;
mod regret;
pub mod report;
pub mod rerun;
pub mod run_args;
pub mod store;
pub mod trials;

use ::campaign::study;
use ::report::{Format, table};
use node::{Exit, Failure};
use scenario::description;
use serde::Serialize;

use crate::progress::while_working;
use crate::stdout::{print, print_json};
use crate::tool;

pub use built_in::BUILT_IN;

/// Subcommands of `hopper campaign`.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// List the built-in campaigns, a line each.
    #[command(after_help = "Examples:\n  hopper campaign list\n  hopper campaign list --format json")]
    List(List),
    /// Fly a campaign, or a shard of one, one row a trial.
    #[command(
        after_help = "Examples:\n  hopper campaign run p23-tables\n  hopper campaign run my.toml --shard 2/8 --out out/my-2\n  hopper campaign run p23-tables --resume"
    )]
    Run(run_args::Args),
    /// Merge the shards of a campaign.
    #[command(after_help = "Examples:\n  hopper campaign merge out/my-1-of-2 out/my-2-of-2 --out out/my")]
    Merge(merge::Args),
    /// Report the results of a campaign, cell by cell.
    #[command(
        after_help = "Examples:\n  hopper campaign report out/p23-tables --against paper\n  hopper campaign report out/p23-tables --format csv > cells.csv"
    )]
    Report(report::Args),
    /// Fly one trial again, with picture and journal, and check its digest.
    #[command(after_help = "Examples:\n  hopper campaign rerun out/p23-tables --trial 17")]
    Rerun(rerun::Args),
}

impl Command {
    /// The study that the campaign named on the command line is of; none if it is one of missions, or cannot be read.
    ///
    /// # Errors
    /// Exit code 2 if there is no such campaign file.
    pub fn study(&self) -> Result<Option<String>, Failure> {
        Ok(match self {
            Command::List(_) => None,
            Command::Run(args) => study::named_in_file(&fly::text(&args.file)?),
            Command::Merge(args) => store::study(args.first()),
            Command::Report(args) => store::study(&args.dir),
            Command::Rerun(args) => store::study(&args.dir),
        })
    }
}

/// Arguments of `hopper campaign list`.
#[derive(clap::Args, Clone, Debug)]
pub struct List {
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Runs the command. A campaign of a study is another program's, which gets the same arguments.
///
/// # Errors
/// Exit code 2 for a wrong campaign, folder or flag, or if the other program is not there; 1 if files cannot be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    if command.study()?.is_some() {
        return tool::exec("hopper-research", std::env::args_os().skip(1));
    }
    match command {
        Command::List(args) => list(args),
        Command::Run(args) => fly::run(args),
        Command::Merge(args) => while_working("merging", || merge::run(args)),
        Command::Report(args) => while_working("reading the rows", || report::run(args)),
        Command::Rerun(args) => while_working("flying the trial again", || rerun::run(args)),
    }
}

/// One built-in campaign; field names are those of the JSON.
#[derive(Serialize)]
struct Listed {
    name: &'static str,
    description: String,
}

fn list(args: &List) -> Result<Exit, Failure> {
    let listed = BUILT_IN.map(|(name, text)| Listed { name, description: description(text) });
    match args.format {
        Format::Text => {
            let rows = listed.map(|Listed { name, description }| [name.to_owned(), description]);
            print(&table(["campaign", "what it is"], &rows))?;
        }
        Format::Json => print_json(&listed)?,
    }
    Ok(Exit::Done)
}
