//! `hopper scenario`: lists the built-in scenarios, checks one, prints the JSON Schema of scenarios.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use ::scenario::{BUILT_IN, Overrides, Scenario, ScenarioCheck, description, fitted_with, load};
use contract::{MotionModel, Profile};
use hopper_sim::elevation_args::ElevationArgs;
use node::{Exit, Failure};
use report::{Format, table};
use serde::Serialize;

use crate::stdout::{print, print_json};

/// Subcommands of `hopper scenario`.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// List the built-in scenarios, a line each.
    #[command(after_help = "Examples:\n  hopper scenario list")]
    List(List),
    /// Write a scenario that fits an elevation model: start and goal on ground that hops connect, a hop that spans whole
    /// cells.
    #[command(after_help = "Examples:\n  hopper scenario new --dem dem.tif --out my.toml")]
    New(New),
    /// Resolve a scenario and summarise what the robot receives, with warnings; exit code 2 if it cannot be flown.
    #[command(
        after_help = "Examples:\n  hopper scenario check my.toml\n  hopper scenario check --dem dem.tif"
    )]
    Check(Args),
    /// Print the JSON Schema of scenarios.
    #[command(after_help = "Examples:\n  hopper scenario schema > scenario.schema.json")]
    Schema,
}

/// Arguments of `hopper scenario list`.
#[derive(clap::Args, Clone, Debug)]
pub struct List {
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Arguments of `hopper scenario new`.
#[derive(clap::Args, Clone, Debug)]
pub struct New {
    /// Elevation model: GeoTIFF or ESRI ASCII, as `hopper terrain check` accepts it.
    #[arg(long, value_name = "FILE")]
    dem: PathBuf,
    #[command(flatten)]
    elevation: ElevationArgs,
    /// File to write; one that exists is not replaced [default: standard output].
    #[arg(long, value_name = "FILE", value_parser = node::output_path())]
    out: Option<PathBuf>,
}

/// Arguments of `hopper scenario check`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// A TOML file, or the name of a built-in scenario: see `hopper scenario list`. With --dem alone, the scenario
    /// that `hopper run --dem` fits to the model.
    #[arg(value_name = "NAME|FILE", required_unless_present = "dem")]
    scenario: Option<PathBuf>,
    /// Profile of the model instead of the scenario's: paper-2023, hopper or paper-2022.
    #[arg(long, value_name = "NAME")]
    profile: Option<Profile>,
    /// Where hops end in truth, instead of the scenario's: law, collision or contact.
    #[arg(long, value_name = "MODEL")]
    dynamics: Option<MotionModel>,
    /// Where planners believe hops to end, instead of the scenario's: a table of `hopper motion derive`.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Elevation model instead of the scenario's.
    #[arg(long, value_name = "FILE")]
    dem: Option<PathBuf>,
    #[command(flatten)]
    elevation: ElevationArgs,
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
        Command::List(args) => list(args)?,
        Command::New(args) => new(args)?,
        Command::Check(args) => {
            let dem = args.dem.as_deref().map(|dem| args.elevation.model(dem)).transpose()?;
            let nodata = args.elevation.nodata();
            let overrides = Overrides {
                profile: args.profile,
                dynamics: args.dynamics,
                table: args.table.clone(),
                dem: dem.clone(),
                nodata: nodata.map(<[f64]>::to_vec),
                ..Overrides::default()
            };
            let scenario = match (&args.scenario, &dem) {
                (None, Some(dem)) => fitted_with(dem, nodata).map(|fitted| fitted.scenario),
                (scenario, _) => load(scenario.as_deref().unwrap_or(Path::new(""))),
            };
            let world =
                scenario.and_then(|scenario| scenario.with(&overrides).resolve()).map_err(Failure::usage)?;
            // What hopper run would refuse for its planners, it refuses here.
            let of_robots = planner::assigned(&world.brief, None, &world.planners);
            let scenario = world.brief.scenario;
            of_robots.map_err(|error| Failure::usage(error.in_scenario(scenario)))?;
            let check = ScenarioCheck::of(&world);
            match args.format {
                Format::Text => print(&check.to_string())?,
                Format::Json => print_json(&check)?,
            }
        }
    }
    Ok(Exit::Done)
}

fn new(args: &New) -> Result<(), Failure> {
    let dem = args.elevation.model(&args.dem)?;
    let fitted = fitted_with(&dem, args.elevation.nodata()).map_err(Failure::usage)?;
    let chosen = fitted.to_string();
    let folder = args.out.as_deref().and_then(Path::parent).filter(|folder| !folder.as_os_str().is_empty());
    let text = fitted.text_in(folder.unwrap_or(Path::new(".")));
    // What is written can be flown.
    let world = fitted.scenario.resolve().map_err(Failure::usage)?;
    for warning in world.warnings.iter().filter(|warning| warning.is_of_ground()) {
        tracing::warn!("{warning}");
    }
    let Some(path) = &args.out else { return print(&text) };
    let written = std::fs::File::create_new(path).and_then(|mut file| file.write_all(text.as_bytes()));
    written
        .map_err(|error| Failure::usage(format!("--out {} cannot be written: {error}", path.display())))?;
    tracing::info!("wrote {0}: {chosen}; fly it with `hopper run --scenario {0}`", path.display());
    Ok(())
}

/// One built-in scenario; field names are those of the JSON.
#[derive(Serialize)]
struct Listed {
    name: &'static str,
    description: String,
}

fn list(args: &List) -> Result<(), Failure> {
    let listed = BUILT_IN.map(|(name, text)| Listed { name, description: description(text) });
    match args.format {
        Format::Text => {
            let rows = listed.map(|Listed { name, description }| [name.to_owned(), description]);
            print(&table(["scenario", "what it is"], &rows))
        }
        Format::Json => print_json(&listed),
    }
}
