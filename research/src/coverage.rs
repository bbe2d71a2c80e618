//! `hopper coverage`: repeats Laîné & Yoshida 2019 (P19), whose rovers cover unknown ground.

pub mod claims;
pub mod figures;
pub mod tables;

use ::campaign::Study as _;
use node::{Exit, Failure};
use p19::{Asked, CASES};

use crate::report::Publication;
use crate::reported::Reported;
use crate::studies::coverage::Coverage;
use crate::studies::{FlownWorld, fly_all, plan};

/// Arguments of `hopper coverage`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Worlds for each case; the paper has 3000.
    #[arg(long, default_value_t = 3000, value_name = "N", value_parser = clap::value_parser!(u64).range(Coverage::WORLDS_MIN..=1_000_000))]
    runs: u64,
    /// Which worlds: run r has seed 1,000,000 · N + r.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000_000))]
    seed: u64,
    #[command(flatten)]
    settings: Coverage,
    #[command(flatten)]
    publication: Publication,
}

/// Runs the study and prints its report.
///
/// # Errors
/// Exit code 2 if the folder cannot be created, 1 if it cannot be written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let worlds = fly_all(&plan(args.settings, args.seed, args.runs))?;
    args.publication.publish(&args.settings.report(args.seed, &worlds))
}

impl Reported for Coverage {
    type Report = tables::Report;

    fn pictures(&self, (): &(), case: usize, seed: u64) -> Result<Vec<(String, String)>, Failure> {
        let Asked { case, percents } = CASES[case];
        Ok(vec![("visits.svg".into(), figures::visits(case, percents, seed)?)])
    }

    fn report(&self, seed: u64, worlds: &[FlownWorld<Self>]) -> tables::Report {
        tables::Report::new(seed, worlds)
    }
}
