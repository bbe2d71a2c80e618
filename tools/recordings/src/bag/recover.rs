//! `hopper bag recover`: writes a whole file from a recording that was cut.

use std::path::PathBuf;

use node::{Exit, Failure};
use recording::Recording;

use super::{Source, at_fault, keep, load, open};

/// Arguments of `hopper bag recover`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    source: Source,
    /// File to write; it must not exist yet.
    #[arg(value_name = "OUT")]
    out: PathBuf,
}

/// Recovers the recording.
///
/// # Errors
/// If it cannot be read or is none, or the new file is there already or cannot be written: then none is made.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    let whole = recording::recover(&recording).map_err(|error| at_fault(path, &error))?;
    let again = Recording::read(&whole).map_err(Failure::run)?;
    assert!(again.is_whole(), "what was recovered is whole: {:?}", again.fault);
    keep(&args.out, &whole)?;
    tracing::info!(
        "{}: {} messages in {} chunks; {} bytes lost",
        args.out.display(),
        again.entries().count(),
        again.chunks(),
        recording.lost_bytes()
    );
    Ok(Exit::Done)
}
