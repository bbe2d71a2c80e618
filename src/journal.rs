//! `hopper journal`: what a journal proves.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use hopper_sim::JournalError;
use hopper_sim::journal::{Show, verify};
use node::{Exit, Failure};
use report::Format;
use serde::Serialize;

/// Tools for the journal of a run.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Check a journal from its first byte to its last; exit code 1 if it is not
    /// sound, 2 if it cannot be read as a journal.
    Verify(Args),
    /// Check a journal, then show its records.
    Show(Args),
}

/// Which journal, in which form.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folder of the journal; it may still be written to.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Form of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Runs the command; done if the journal is sound, failed if it is readable but not sound.
///
/// # Errors
/// If the journal is missing, damaged, or cannot be read.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    let mut out = io::stdout().lock();
    let (written, is_sound) = match command {
        Command::Verify(Args { dir, format }) => {
            let verification = verify(folder(dir)?).map_err(failure)?;
            let written = match format {
                Format::Text => write!(out, "{verification}"),
                Format::Json => json(&mut out, &verification),
            };
            (written, verification.is_sound())
        }
        Command::Show(Args { dir, format }) => {
            let show = Show::new(folder(dir)?).map_err(failure)?;
            let written = match format {
                Format::Text => text(&mut out, &show)?,
                Format::Json => json(&mut out, &show),
            };
            (written, show.verification.is_sound())
        }
    };
    match written.and_then(|()| out.flush()) {
        // The reader has seen enough.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => {}
        written => written?,
    }
    Ok(if is_sound { Exit::Done } else { Exit::Failed })
}

fn text(out: &mut impl Write, show: &Show) -> Result<io::Result<()>, Failure> {
    for table in show.tables() {
        if let Err(error) = writeln!(out, "{}", table.map_err(failure)?) {
            return Ok(Err(error));
        }
    }
    Ok(write!(out, "{}", show.verification))
}

fn json(out: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *out, value)?;
    writeln!(out)
}

/// The journal's folder, which somebody may have taken the file in it for.
fn folder(path: &Path) -> Result<&Path, Failure> {
    if path.is_file() {
        let message =
            format!("a journal is a folder, got the file {}: give the folder it is in", path.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(path)
}

fn failure(error: JournalError) -> Failure {
    Failure::new(error.exit(), error.to_string())
}
