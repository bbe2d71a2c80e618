//! `hopper scenario`: checks a scenario, prints the JSON Schema of scenarios.

use std::path::PathBuf;

use ::scenario::{Overrides, Scenario, ScenarioCheck, load};
use contract::Profile;
use node::{Exit, Failure};
use report::Format;

use crate::stdout::{print, print_json};

/// Subcommands of `hopper scenario`.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Resolve a scenario and summarise what the robot is told, with warnings; exit code 2 if it cannot be flown.
    Check(Args),
    /// Print the JSON Schema of scenarios.
    Schema,
}

/// Arguments of `hopper scenario check`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// A TOML file, or the name of a built-in scenario: hard, heterogeneous, sandy, large, treasures, wide,
    /// vast, hills, mars, patrol.
    #[arg(value_name = "NAME|FILE")]
    scenario: String,
    /// Profile of the model instead of the scenario's: paper-2023 or hopper.
    #[arg(long, value_name = "NAME")]
    profile: Option<Profile>,
    /// Elevation model instead of the scenario's.
    #[arg(long, value_name = "FILE")]
    dem: Option<PathBuf>,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 if the scenario or its terrain is invalid.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Schema => {
            let schema = serde_json::to_string_pretty(&Scenario::schema()).map_err(Failure::run)?;
            print(&(schema + "\n"))?;
        }
        Command::Check(args) => {
            let overrides =
                Overrides { profile: args.profile, dem: args.dem.clone(), ..Overrides::default() };
            let world = load(&args.scenario)
                .and_then(|scenario| scenario.with(&overrides).resolve())
                .map_err(Failure::usage)?;
            let check = ScenarioCheck::of(&world);
            match args.format {
                Format::Text => print(&check.to_string())?,
                Format::Json => print_json(&check)?,
            }
        }
    }
    Ok(Exit::Done)
}
