//! `hopper campaign merge`: merges the shards of a campaign row by row.

use std::path::{Path, PathBuf};

use ::campaign::{Plan, Shard, TrialPlan};
use node::{Exit, Failure};

use super::store::{self, Manifest, Rows, Store, Times};
use crate::stdout::print;

/// Arguments of `hopper campaign merge`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folders of all shards, in any order.
    #[arg(value_name = "DIR", required = true)]
    dirs: Vec<PathBuf>,
    /// Folder for the whole [default: out/NAME].
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
}

impl Args {
    /// The first of the folders.
    #[must_use]
    pub fn first(&self) -> &Path {
        &self.dirs[0]
    }
}

/// Merges the shards of a campaign of missions.
///
/// # Errors
/// As [`shards`].
pub fn run(args: &Args) -> Result<Exit, Failure> {
    shards::<Plan>(args)
}

/// Merges the shards of a campaign.
///
/// # Errors
/// Exit code 2 if a shard is missing, given twice, unfinished, or of another campaign.
pub fn shards<P: TrialPlan>(args: &Args) -> Result<Exit, Failure> {
    let parts = args.dirs.iter().map(|dir| Ok((dir, store::manifest::<P>(dir)?)));
    let mut parts = parts.collect::<Result<Vec<_>, Failure>>()?;
    parts.sort_by_key(|(_, manifest)| manifest.shard.number);
    check(&parts)?;
    let plan = parts[0].1.plan.clone();
    let trials = plan.trials();
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(plan.identity().name));
    let whole = Manifest { shard: Shard::WHOLE, plan };
    let mut store = Store::open(&out, &whole, false)?;
    let mut rows =
        parts.iter().map(|(dir, manifest)| Rows::open(dir, manifest)).collect::<Result<Vec<_>, _>>()?;
    let mut times = parts.iter().map(|(dir, _)| store::times(dir)).collect::<Result<Vec<_>, _>>()?;
    for trial in 0..trials {
        let part = (trial % parts.len() as u64) as usize;
        let Some(row) = rows[part].next()? else {
            let (dir, manifest) = &parts[part];
            return Err(Failure::usage(format!(
                "{}: shard {} is not finished, trial {trial} is missing: run it with --resume",
                dir.display(),
                manifest.shard
            )));
        };
        let times = times[part].next().filter(|times| times.trial == trial);
        let times = times.unwrap_or_else(|| Times::unknown(trial));
        store.append(&row, &times)?;
    }
    store.flush()?;
    print(&format!("{trials} rows in {}; see: hopper campaign report {}\n", out.display(), out.display()))?;
    Ok(Exit::Done)
}

fn check<P: TrialPlan>(parts: &[(&PathBuf, Manifest<P>)]) -> Result<(), Failure> {
    let (first_dir, first) = &parts[0];
    for (dir, manifest) in parts {
        if manifest.plan != first.plan || manifest.shard.count != first.shard.count {
            return Err(Failure::usage(format!(
                "need shards of one campaign, got {} (plan {}, shard {}) and {} (plan {}, shard {})",
                first_dir.display(),
                first.plan.identity().hash,
                first.shard,
                dir.display(),
                manifest.plan.identity().hash,
                manifest.shard
            )));
        }
    }
    let numbers: Vec<u64> = parts.iter().map(|(_, manifest)| manifest.shard.number).collect();
    if let Some(twice) = numbers.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Failure::usage(format!("shard {}/{} is given twice", twice[0], first.shard.count)));
    }
    let missing = (1..=first.shard.count).find(|number| !numbers.contains(number));
    match missing {
        Some(number) => Err(Failure::usage(format!("shard {number}/{} is missing", first.shard.count))),
        None => Ok(()),
    }
}
