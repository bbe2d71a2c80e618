//! `hopper bag recover`: writes a whole file from a recording that was cut, or that another program has written.

use std::path::PathBuf;

use node::{Exit, Failure};
use recording::{Recording, SkippedMessages};

use super::{Source, at_fault, keep, load, open, warn_of_skipped};

/// Arguments of `hopper bag recover`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    source: Source,
    /// File to write; it must not exist yet.
    #[arg(value_name = "OUT", value_parser = node::output_file_of(&["mcap"]))]
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
    let undecodable = recording.undecodable();
    let messages = recording.entries().count() as u64 - undecodable.messages;
    if messages == 0 {
        return Err(Failure::usage(format!("{}: {}", path.display(), nothing(&recording, &undecodable))));
    }
    warn_of_skipped(path, &undecodable);
    let whole = recording::recover(&recording).map_err(|error| at_fault(path, &error))?;
    let again = Recording::read(&whole).map_err(Failure::run)?;
    assert!(again.is_whole(), "what was recovered is whole: {:?}", again.fault);
    assert_eq!(again.entries().count() as u64, messages, "every message that can be read is recovered");
    keep(&args.out, &whole)?;
    let mut lost = format!("{} bytes lost", recording.lost_bytes());
    for (count, what) in [
        (undecodable.messages, "messages that cannot be decoded"),
        (recording.without_channel(), "messages without a channel"),
        (recording.attachments() as u64, "attachments"),
    ] {
        if count > 0 {
            lost += &format!(", {count} {what} left out");
        }
    }
    tracing::info!("{}: wrote {messages} messages in {} chunks; {lost}", args.out.display(), again.chunks());
    Ok(Exit::Done)
}

/// Why nothing can be recovered.
fn nothing(recording: &Recording<'_>, undecodable: &SkippedMessages) -> String {
    let why = match (&recording.fault, &undecodable.first) {
        (Some(fault), None) => fault.clone(),
        (None, None) => "it has none".into(),
        (_, Some(_)) => undecodable.to_string(),
    };
    format!("no message can be recovered, so no file is written: {why}")
}
