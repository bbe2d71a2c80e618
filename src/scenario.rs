//! `hopper scenario`: whether a scenario can be flown, and how scenarios are written.

use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

use ::scenario::{Overrides, Scenario, ScenarioCheck, load};
use contract::Profile;
use node::{Exit, Failure};
use report::Format;

/// Tools for scenarios.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Resolve a scenario and sum up its brief, with warnings; exit code 2 if it cannot be flown.
    Check(Args),
    /// Print the JSON Schema of scenarios.
    Schema,
}

/// Which scenario, in which form.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// A scenario's file, or the name of a built-in one: hard, heterogeneous, sandy, large, treasures, wide,
    /// vast, hills, mars.
    #[arg(value_name = "NAME|FILE")]
    scenario: String,
    /// Reading of the model, instead of the scenario's: paper-2023 or hopper.
    #[arg(long, value_name = "NAME")]
    profile: Option<Profile>,
    /// Elevation model, instead of the scenario's.
    #[arg(long, value_name = "FILE")]
    dem: Option<PathBuf>,
    /// Form of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 with what is wrong with the scenario or its terrain.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    let mut out = io::stdout().lock();
    let written = match command {
        Command::Schema => serde_json::to_writer_pretty(&mut out, &Scenario::schema())
            .map_err(io::Error::from)
            .and_then(|()| writeln!(out)),
        Command::Check(args) => {
            let overrides =
                Overrides { profile: args.profile, dem: args.dem.clone(), ..Overrides::default() };
            let world = load(&args.scenario)
                .and_then(|scenario| scenario.with(&overrides).resolve())
                .map_err(Failure::usage)?;
            let check = ScenarioCheck::of(&world);
            match args.format {
                Format::Text => write!(out, "{check}"),
                Format::Json => serde_json::to_writer(&mut out, &check)
                    .map_err(io::Error::from)
                    .and_then(|()| writeln!(out)),
            }
        }
    };
    match written.and_then(|()| out.flush()) {
        // The reader has seen enough.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => {}
        written => written?,
    }
    Ok(Exit::Done)
}
