//! `hopper coverage`: repeats Laîné & Yoshida 2019 (P19), whose rovers cover unknown ground.

pub mod case;
pub mod claims;
pub mod estimate;
pub mod figures;
pub mod study;
mod tables;

use std::path::PathBuf;

use hopper::stdout::print;
use node::{Exit, Failure};

use crate::form::{Form, write_out};
use case::Sampling;
use study::Study;
use tables::Report;

/// Fewest runs for which the intervals are meant.
const RUNS_MIN: u64 = 100;

/// Arguments of `hopper coverage`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Worlds for each case; the paper has 3000.
    #[arg(long, default_value_t = 3000, value_name = "N", value_parser = clap::value_parser!(u64).range(RUNS_MIN..=1_000_000))]
    runs: u64,
    /// Which worlds: run r has seed 1,000,000 · N + r.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000_000))]
    seed: u64,
    /// Write the figures and the report in all formats into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Format of the report on standard output.
    #[arg(long, default_value_t)]
    format: Form,
}

/// Runs the study and prints its report.
///
/// # Errors
/// Exit code 2 if the folder cannot be created, 1 if it cannot be written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let study = Study::new(Sampling { seed: args.seed, runs: args.runs })?;
    let figures = figures::all(&study);
    let report = Report::new(study);
    if let Some(dir) = &args.out {
        let reports =
            [("coverage.txt", Form::Text), ("coverage.md", Form::Markdown), ("coverage.json", Form::Json)];
        let reports = reports.map(|(name, form)| report.written(form).map(|text| (name.to_owned(), text)));
        let reports = reports.into_iter().collect::<Result<Vec<_>, Failure>>()?;
        let files: Vec<_> = reports.into_iter().chain(figures).collect();
        write_out(dir, files.iter().map(|(name, text)| (name.clone(), text.as_str())))?;
    }
    print(&report.written(args.format)?)?;
    Ok(Exit::Done)
}
