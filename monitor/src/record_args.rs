//! What is to be recorded, on the command line.

use std::path::{Path, PathBuf};

/// Options of `hopper monitor --record`.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Recording")]
pub struct RecordArgs {
    /// Record every public message as MCAP, readable by Foxglove, Rerun, and Python's mcap.
    #[arg(long, value_name = "FILE", value_parser = node::output_file_of(&["mcap"]))]
    pub record: Option<PathBuf>,
    /// Ask planners for their policies and record them too, which costs a planner time at every decision.
    #[arg(long, requires = "record")]
    pub record_policies: bool,
}

/// What only the command that starts the mission knows: kept in the recording, shown to nobody else.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct RecordNotes {
    /// Scenario file to keep in the recording: no public message carries it.
    #[arg(long, requires = "record", value_name = "FILE", help_heading = "Recording")]
    pub record_scenario: Option<PathBuf>,
    /// What else to note in the recording, e.g. seed=7 or pace=20.
    #[arg(long, requires = "record", value_name = "KEY=VALUE", value_parser = note, help_heading = "Recording")]
    pub record_note: Vec<(String, String)>,
}

fn note(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or_else(|| format!("a note needs KEY=VALUE, got {text:?}"))?;
    Ok((key.into(), value.into()))
}

/// FILE, FILE-2, FILE-3, …: where a recording goes, and where it goes on each time the monitor was killed.
pub fn files(path: &Path) -> impl Iterator<Item = PathBuf> {
    let first = path.to_owned();
    let others = first.clone();
    let numbered = (2..).map(move |number: u64| {
        let mut name = others.file_stem().unwrap_or_default().to_owned();
        name.push(format!("-{number}"));
        if let Some(extension) = others.extension() {
            name.push(".");
            name.push(extension);
        }
        others.with_file_name(name)
    });
    std::iter::once(first).chain(numbered)
}
