//! `hopper bag`: inspects, recovers, replays and exports recordings.

mod export;
mod info;
mod recover;
mod replay;
mod ros2_bag;

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use contract::Brief;
use node::{Exit, Failure};
use recording::{Recording, RecordingError, SkippedMessages};
use scenario::{ResolvedScenario, Scenario};

/// Tools for recordings made by `hopper run --record` or `hopper monitor --record`.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Show what is in a recording; exit code 1 if it is not whole.
    #[command(
        after_help = "Examples:\n  hopper bag info hard.mcap\n  hopper bag info hard.mcap --scenario > hard.toml"
    )]
    Info(info::Args),
    /// Write a whole file from a recording that was cut, up to its last valid chunk.
    #[command(after_help = "Examples:\n  hopper bag recover cut.mcap whole.mcap")]
    Recover(recover::Args),
    /// Let a planner decide again on what was sensed, and show where it decides differently.
    #[command(
        after_help = "Examples:\n  hopper bag replay hard.mcap\n  hopper bag replay hard.mcap --planner greedy --rate 10"
    )]
    Replay(replay::Args),
    /// Print decisions, or the messages of a topic, as rows; or write a bag of ROS 2.
    #[command(
        after_help = "Examples:\n  hopper bag export hard.mcap > decisions.csv\n  hopper bag export hard.mcap --topic hop/state --format json\n  hopper bag export hard.mcap --ros2 hard-ros2"
    )]
    Export(export::Args),
}

impl Command {
    /// Whether it waits for its user, or keeps to a pace that its user chose.
    #[must_use]
    pub fn is_by_hand(&self) -> bool {
        matches!(self, Command::Replay(args) if args.is_by_hand())
    }
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read, is no recording, or cannot be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Info(args) => info::run(args),
        Command::Recover(args) => recover::run(args),
        Command::Replay(args) => replay::run(args),
        Command::Export(args) => export::run(args),
    }
}

/// The bytes of a recording.
///
/// # Errors
/// Exit code 2 if the file cannot be read.
pub fn load(path: &Path) -> Result<Vec<u8>, Failure> {
    let unread =
        |why: &dyn std::fmt::Display| Failure::usage(format!("{} cannot be read: {why}", path.display()));
    let kind = path.metadata().map_err(|error| unread(&error))?.file_type();
    if !kind.is_file() {
        // A pipe might never be opened, and a device never end.
        let got = if kind.is_dir() { "a folder" } else { "a pipe, a device or a socket" };
        return Err(unread(&format!("need a recording, got {got}")));
    }
    std::fs::read(path).map_err(|error| unread(&error))
}

/// The recording in `bytes`, with a warning if it is not whole.
///
/// # Errors
/// Exit code 2 if `bytes` are no recording.
pub fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<Recording<'a>, Failure> {
    let recording = Recording::read(bytes).map_err(|error| at_fault(path, &error))?;
    if let Some(fault) = &recording.fault {
        let lost = match recording.lost_bytes() {
            0 => String::new(),
            bytes => format!("; its last {bytes} bytes are left out"),
        };
        tracing::warn!("{} is not whole: {fault}{lost}", path.display());
    }
    Ok(recording)
}

/// Warns of messages that were left out.
pub fn warn_of_skipped(path: &Path, skipped: &SkippedMessages) {
    if !skipped.is_empty() {
        tracing::warn!("{}: left out what is damaged: {skipped}", path.display());
    }
}

/// The scenario of `brief` among those that the recording keeps, and what comes of it.
///
/// # Errors
/// If the recording keeps a single scenario, and it is malformed.
pub fn scenario_of<'a>(
    recording: &'a Recording<'_>,
    brief: &Brief,
) -> Result<Option<(&'a str, ResolvedScenario)>, Failure> {
    let texts = scenarios(recording);
    let is_alone = texts.len() == 1;
    for text in texts {
        let resolved = Scenario::parse(text, "the recording's scenario").and_then(|parsed| parsed.resolve());
        match resolved {
            Ok(world)
                if (world.brief.scenario_hash, world.brief.grid) == (brief.scenario_hash, brief.grid) =>
            {
                return Ok(Some((text, world)));
            }
            Err(error) if is_alone => return Err(Failure::usage(error)),
            _ => {}
        }
    }
    Ok(None)
}

/// The scenarios that the recording keeps.
pub fn scenarios<'a>(recording: &'a Recording<'_>) -> Vec<&'a str> {
    let texts = recording.metadata_named("scenario").into_iter();
    texts.filter_map(|entries| entries.get("toml").map(String::as_str)).collect()
}

/// A failure that names the recording, with exit code 2.
#[must_use]
pub fn at_fault(path: &Path, error: &RecordingError) -> Failure {
    Failure::new(Exit::Usage, format!("{}: {error}", path.display()))
}

/// Writes a new file for its owner only: whole, or not at all.
///
/// # Errors
/// Exit code 2 if it is there already, names a folder, or its folder cannot be written to; 1 if it cannot be written.
pub fn keep(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let folder = folder_for(path, "file")?;
    // Under another name until it is whole; dropping `file` removes it.
    let file = tempfile::Builder::new().prefix(".hopper-").tempfile_in(folder);
    let mut file = file.map_err(|error| unwritten(path, Exit::Usage, &error.kind().into()))?;
    file.as_file_mut().write_all(bytes).map_err(|error| unwritten(path, Exit::Failed, &error))?;
    match file.persist_noclobber(path) {
        Ok(_) => Ok(()),
        Err(error) if error.error.kind() == ErrorKind::AlreadyExists => Err(there(path, "file")),
        Err(error) => Err(unwritten(path, Exit::Failed, &error.error)),
    }
}

/// The folder in which a new file or folder, whichever `what` says, is to be made.
///
/// # Errors
/// Exit code 2 if it is there already, has no name, or its folder is not there.
pub fn folder_for<'a>(path: &'a Path, what: &str) -> Result<&'a Path, Failure> {
    let need = |what: String| Failure::usage(format!("{} cannot be written: {what}", path.display()));
    if path.symlink_metadata().is_ok() {
        return Err(there(path, what));
    }
    let ends_in = |end: &[u8]| path.as_os_str().as_encoded_bytes().ends_with(end);
    let is_named = what == "folder" || !(ends_in(b"/") || ends_in(b"/."));
    if path.file_name().is_none() || !is_named {
        return Err(need(format!("need the name of a {what}, got a folder")));
    }
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    match folder.metadata() {
        Ok(kind) if kind.is_dir() => Ok(folder),
        Ok(_) => Err(need(format!("need a folder, got the file {}", folder.display()))),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            Err(need(format!("need a folder that exists, got {}", folder.display())))
        }
        Err(error) => Err(unwritten(path, Exit::Usage, &error)),
    }
}

fn there(path: &Path, what: &str) -> Failure {
    Failure::new(Exit::Usage, format!("{} exists already: name another {what}", path.display()))
}

/// A failure that names what cannot be written.
#[must_use]
pub fn unwritten(path: &Path, exit: Exit, error: &io::Error) -> Failure {
    Failure::new(exit, format!("{} cannot be written: {error}", path.display()))
}

/// A recording on the command line.
#[derive(clap::Args, Clone, Debug)]
pub struct Source {
    /// The recording; it may still be written to, or have been cut.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
}
