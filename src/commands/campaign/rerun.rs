//! `hopper campaign rerun`: flies one trial again, with picture and journal.

use std::path::PathBuf;

use ::campaign::{Plan, Row};
use hopper_sim::shell::print_summary;
use node::{Exit, Failure};
use report::{Format, Summary};
use scenario::ResolvedScenario;

use super::fly::schedule;
use super::store;
use crate::mission::OutputDir;
use crate::mission::run::in_lockstep;

/// Arguments of `hopper campaign rerun`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folder of a campaign.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Number of the trial, as in its row.
    #[arg(long, value_name = "K")]
    pub trial: u64,
    /// Folder for journal, summary and picture; of a study, for row and pictures [default: a new folder under out/].
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    pub out: Option<PathBuf>,
    /// Form of the summary on standard output: text or json.
    #[arg(long, default_value_t)]
    pub format: Format,
}

/// Flies the trial again and prints its summary.
///
/// # Errors
/// Exit code 2 if the folder does not hold the trial, 1 if the digest is not the row's.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let manifest = store::manifest::<Plan>(&args.dir)?;
    let row = store::row(&args.dir, &manifest, args.trial)?;
    let Some(trial) = manifest.plan.trial(row.trial) else {
        return Err(Failure::usage(format!("trial {} is not in the plan", row.trial)));
    };
    let world = trial.cell.world().map_err(Failure::usage)?;
    let held = args.out.as_deref().and_then(|dir| Some((dir, OutputDir::ended(dir, &world, row.seed)?)));
    let summary = match held {
        Some((dir, summary)) => {
            tracing::info!("{} has already ended, nothing flown", dir.display());
            summary
        }
        None => fly(args, &world, &row, &trial.cell.planner)?,
    };
    print_summary(&summary, args.format)?;
    if summary.digest != row.digest {
        return Err(Failure::run(format!(
            "trial {}: need the digest of its row, {}, got {}: this program (version {}) is not the one that flew it \
             (version {})",
            row.trial,
            row.digest,
            summary.digest,
            store::VERSION,
            row.version
        )));
    }
    Ok(Exit::Done)
}

/// Flies the trial of `row` into the output folder.
fn fly(args: &Args, world: &ResolvedScenario, row: &Row, planner: &str) -> Result<Summary, Failure> {
    let (output_dir, journal) = OutputDir::open(args.out.clone(), world, row.seed)?;
    let schedule = schedule(world, planner)?;
    let mut summary = in_lockstep(world, row.seed, &schedule, &output_dir, journal)?;
    output_dir.illustrate(world, &mut summary, report::PictureStyle::Screen)?;
    output_dir.keep(&summary)?;
    Ok(summary)
}
