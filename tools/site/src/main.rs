//! `hopper-site`: builds the page without a server, and checks that it flies as this machine does.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use process::{Exit, Failure};

#[derive(Parser)]
#[command(
    name = "hopper-site",
    version,
    about = "The page without a server: static files that fly missions in the browser"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build the static files. Needs the sources and the target wasm32-unknown-unknown.
    #[command(after_help = "Example:\n  cargo run --release -p hopper-site -- build out/site")]
    Build {
        /// Folder for the files: a new one, or one built before.
        #[arg(value_name = "DIR")]
        out: PathBuf,
    },
    /// Fly missions in Node with the module of a built folder, and compare every outcome with that of this machine.
    #[command(after_help = "Example:\n  cargo run --release -p hopper-site -- check out/site --seeds 1000")]
    Check {
        /// Folder that was built.
        #[arg(value_name = "DIR")]
        site: PathBuf,
        /// How many seeds, from 1 on.
        #[arg(long, default_value_t = 1000, value_name = "NUMBER")]
        seeds: u64,
    },
}

fn main() -> ExitCode {
    match run(&Cli::parse().command) {
        Ok(text) => {
            // Fails only if nobody reads.
            let _ = writeln!(std::io::stdout(), "{text}");
            ExitCode::SUCCESS
        }
        Err(failure) => {
            let _ = writeln!(std::io::stderr(), "hopper-site: {failure}");
            ExitCode::from(failure.exit.code())
        }
    }
}

fn run(command: &Command) -> Result<String, Failure> {
    match command {
        Command::Build { out } => {
            let site = hopper_site::build(out)?;
            if site.compressed_bytes > hopper_site::COMPRESSED_BYTES_MAX {
                let (need, got) = (hopper_site::COMPRESSED_BYTES_MAX, site.compressed_bytes);
                let message = format!("{} needs at most {need} bytes compressed, got {got}", out.display());
                return Err(Failure::new(Exit::Threshold, message));
            }
            Ok(format!("{}: {site}", out.display()))
        }
        Command::Check { site, seeds } => {
            let missions = hopper_site::missions(*seeds);
            let differences = hopper_site::differences(site, &missions)?;
            match differences.first() {
                None => Ok(format!("{} missions end with the digest of this machine", missions.len())),
                Some(first) => {
                    let message = format!(
                        "{} of {} missions differ, the first: {first}",
                        differences.len(),
                        missions.len()
                    );
                    Err(Failure::new(Exit::Failed, message))
                }
            }
        }
    }
}
