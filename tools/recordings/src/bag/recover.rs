//! `hopper bag recover`: writes a whole file from a recording that was cut, or that another program has written.

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
    #[arg(value_name = "OUT", value_parser = node::output_path())]
    out: PathBuf,
}

/// Recovers the recording.
///
/// # Errors
/// If it cannot be read or is none, if nothing of it can be recovered, or the new file is there already or cannot be
/// written: then none is made.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    if let (Some(fault), None) = (&recording.fault, recording.entries().next()) {
        return Err(Failure::usage(format!(
            "{}: nothing can be recovered, since no message stands before {fault}",
            path.display()
        )));
    }
    let whole = recording::recover(&recording).map_err(|error| at_fault(path, &error))?;
    let again = Recording::read(&whole).map_err(Failure::run)?;
    assert!(again.is_whole(), "what was recovered is whole: {:?}", again.fault);
    let messages = again.entries().count();
    assert_eq!(messages, recording.entries().count(), "every message that was read is recovered");
    keep(&args.out, &whole)?;
    let lost = match (recording.lost_bytes(), recording.attachments()) {
        (bytes, 0) => format!("{bytes} bytes lost"),
        (bytes, attachments) => format!("{bytes} bytes lost, {attachments} attachments left out"),
    };
    tracing::info!("{}: wrote {messages} messages in {} chunks; {lost}", args.out.display(), again.chunks());
    Ok(Exit::Done)
}
