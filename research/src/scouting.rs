//! `hopper scouting`: repeats the studies of Folsom et al. 2021 (P21), a rover with a helicopter.

mod arms;
mod figures;
pub mod large;
pub mod monte_carlo;
pub mod scale;
pub mod single;

use clap::Subcommand;
use node::{Exit, Failure};

/// The paper, as reports name it.
const FOLSOM: &str = "Folsom et al. 2021";

/// Arguments of `hopper scouting`.
#[derive(clap::Args, Clone, Debug)]
#[group(skip)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    study: Option<Study>,
    #[command(flatten)]
    monte_carlo: monte_carlo::Args,
}

/// The studies besides the Monte Carlo simulation.
#[derive(Subcommand, Clone, Debug)]
enum Study {
    /// A single agent that gathers information on its way across a small grid.
    #[command(after_help = "Examples:\n  hopper scouting single --out out/single")]
    Single(single::Args),
    /// Rover and helicopter on a large made map, in place of the paper's map of Jezero.
    #[command(
        after_help = "Examples:\n  hopper scouting large --runs 20\n  hopper scouting large --stages 3"
    )]
    Large(large::Args),
    /// The time that planning takes on maps of 100 to 674,041 cells.
    #[command(after_help = "Examples:\n  hopper scouting scale --rounds 1")]
    Scale(scale::Args),
}

/// Runs a study and prints its report.
///
/// # Errors
/// Exit code 2 if the folder for the figures cannot be created, 1 if a report cannot be printed or written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    match &args.study {
        None => monte_carlo::run(&args.monte_carlo),
        Some(Study::Single(args)) => single::run(args),
        Some(Study::Large(args)) => large::run(args),
        Some(Study::Scale(args)) => scale::run(args),
    }
}
