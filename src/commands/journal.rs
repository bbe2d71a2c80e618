//! `hopper journal`: verifies the journal of a mission, shows its records.

use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use hopper_sim::journal::{Show, Verification, verify};
use hopper_sim::{Journal, JournalReader};
use node::{Exit, Failure};
use report::{Format, PictureStyle};
use serde::Serialize;

use crate::files::write_picture;
use crate::mission::Flown;
use crate::mission::comparison::{Difference, against_lockstep};
use crate::stdout::{print, print_json, stream};

/// Subcommands of `hopper journal`.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Check a journal from its first byte to its last; exit code 1 if it is not sound, 2 if it is no journal.
    #[command(
        after_help = "Examples:\n  hopper journal verify out/hard-1\n  hopper journal verify out/hard-1 --against-lockstep"
    )]
    Verify(VerifyArgs),
    /// Check a journal, then show its records.
    #[command(
        after_help = "Examples:\n  hopper journal show out/hard-1\n  hopper journal show out/hard-1 --format json > hard-1.json"
    )]
    Show(Args),
    /// Draw the mission again, at any hop, for screen or paper.
    #[command(
        after_help = "Examples:\n  hopper journal draw out/hard-1 --at 20 --out start.svg\n  hopper journal draw out/hard-1 --picture paper --out hard.pdf"
    )]
    Draw(DrawArgs),
}

/// Arguments of `hopper journal draw`.
#[derive(clap::Args, Clone, Debug)]
pub struct DrawArgs {
    /// Folder of the journal, or the output folder of the run.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Draw it as it stood after so many decisions [default: all].
    #[arg(long, value_name = "N")]
    at: Option<usize>,
    /// What it is drawn for: screen, or paper, which is one column (85 mm) wide without a title.
    #[arg(long, default_value_t, value_name = "STYLE")]
    picture: PictureStyle,
    /// File to write: SVG, or PDF if it ends in .pdf; an old one is replaced.
    #[arg(long, value_name = "FILE", default_value = "mission.svg", value_parser = node::output_file_of(&["svg", "pdf"]))]
    out: PathBuf,
}

/// Arguments of `hopper journal verify` and `hopper journal show`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folder of the journal, or the output folder of the run; a mission may be writing to it.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Arguments of `hopper journal verify`.
#[derive(clap::Args, Clone, Debug)]
pub struct VerifyArgs {
    #[command(flatten)]
    args: Args,
    /// Fly the mission again in lockstep, and compare the digest and the map of every decision.
    #[arg(long)]
    against_lockstep: bool,
}

/// Runs the command: done if the journal is sound, failed if it can be read but is not sound.
///
/// # Errors
/// If the journal is missing, damaged, or cannot be read.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    let is_sound = match command {
        Command::Verify(VerifyArgs { args: Args { dir, format }, against_lockstep: false }) => {
            let verification = verify(&folder(dir)?)?;
            match format {
                Format::Text => print(&verification.to_string())?,
                Format::Json => print_json(&verification)?,
            }
            verification.is_sound()
        }
        Command::Verify(VerifyArgs { args: Args { dir, format }, .. }) => {
            let verification = verify(&folder(dir)?)?;
            // What cannot have been flown is not flown again.
            let difference = match verification.is_sound() {
                true => {
                    require_ground(&folder(dir)?)?;
                    against_lockstep(&folder(dir)?)?
                }
                false => None,
            };
            match (format, &difference) {
                (Format::Text, None) if !verification.is_sound() => print(&verification.to_string())?,
                (Format::Text, None) => {
                    let decisions = verification.decisions;
                    print(&format!(
                        "{verification}  lockstep    the same digest and map at each of {decisions} decisions\n"
                    ))?;
                }
                (Format::Text, Some(difference)) => {
                    print(&format!("{verification}  FAULT       {difference}\n"))?;
                }
                (Format::Json, _) => {
                    print_json(&AgainstLockstep { verification: &verification, difference })?
                }
            }
            verification.is_sound() && difference.is_none()
        }
        Command::Show(Args { dir, format }) => {
            let show = Show::new(&folder(dir)?)?;
            match format {
                Format::Text => print_tables(&show)?,
                Format::Json => stream(|out| {
                    serde_json::to_writer(&mut *out, &show)?;
                    writeln!(out)
                })?,
            }
            show.verification.is_sound()
        }
        Command::Draw(args) => return draw(args),
    };
    Ok(if is_sound { Exit::Done } else { Exit::Failed })
}

fn draw(args: &DrawArgs) -> Result<Exit, Failure> {
    let dir = folder(&args.dir)?;
    require_ground(&dir)?;
    let flown = Flown::read(&dir)?;
    let most = flown.records.len();
    let at = args.at.unwrap_or(most);
    if at > most {
        let dir = args.dir.display();
        return Err(Failure::usage(format!("--at needs 0 to {most}, the decisions of {dir}, got {at}")));
    }
    for picture in flown.pictures(&[at], args.picture)? {
        write_picture(&args.out, &picture)?;
    }
    Ok(Exit::Done)
}

/// Refuses a journal whose ground is missing or another one: what is drawn or flown on that is not its mission.
fn require_ground(dir: &Path) -> Result<(), Failure> {
    JournalReader::open(dir)?.world()?;
    Ok(())
}

/// What `--against-lockstep` prints in JSON.
#[derive(Serialize)]
struct AgainstLockstep<'a> {
    #[serde(flatten)]
    verification: &'a Verification,
    /// The first decision that lockstep takes otherwise.
    difference: Option<Difference>,
}

/// Prints the records table by table: a journal may be longer than memory holds.
fn print_tables(show: &Show) -> Result<(), Failure> {
    let mut unreadable = None;
    stream(|out| {
        for table in show.tables() {
            match table {
                Ok(table) => writeln!(out, "{table}")?,
                Err(error) => {
                    unreadable = Some(error);
                    return Ok(());
                }
            }
        }
        write!(out, "{}", show.verification)
    })?;
    unreadable.map_or(Ok(()), |error| Err(error.into()))
}

/// The folder of the journal: `path`, or the one in it if `path` is the output folder of a run.
///
/// # Errors
/// If `path` is no folder, as the file inside the journal's is none, or nobody here may look into it.
pub fn folder(path: &Path) -> Result<PathBuf, Failure> {
    if path.exists() && !path.is_dir() {
        let message = format!(
            "need the folder of a journal, got the file {}: name the folder that holds it",
            path.display()
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    if let Err(error) = std::fs::read_dir(path)
        && error.kind() == ErrorKind::PermissionDenied
    {
        let message = format!("need a journal that you may read, got {}: {}", path.display(), error.kind());
        return Err(Failure::new(Exit::Usage, message));
    }
    let inner = path.join("journal");
    Ok(if !Journal::exists(path) && Journal::exists(&inner) { inner } else { path.into() })
}
