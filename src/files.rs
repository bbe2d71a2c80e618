//! Files that a command writes into a folder of the user's choice.

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::FileTypeExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

use hopper_sim::private_file::{self, FileError};
use node::Failure;

use crate::tool;

/// Writes `files`, names and texts, into `dir`, which is created if it does not exist.
///
/// # Errors
/// Exit code 2 if the folder cannot be created, 1 if a file cannot be written.
pub fn write_into(
    dir: &Path,
    files: impl IntoIterator<Item = (impl AsRef<str>, impl AsRef<str>)>,
) -> Result<(), Failure> {
    fs::create_dir_all(dir)
        .map_err(|error| Failure::usage(format!("--out {} cannot be made: {error}", dir.display())))?;
    let mut count = 0_usize;
    for (name, text) in files {
        count += 1;
        let path = dir.join(name.as_ref());
        private_file::write_shared(&path, text.as_ref()).map_err(|error| match error {
            FileError::Io { path, source, .. } => {
                Failure::run(format!("{} cannot be written: {source}", path.display()))
            }
            refused => Failure::usage(refused),
        })?;
    }
    tracing::info!("wrote {count} files to {}", dir.display());
    Ok(())
}

/// Writes a file where the user asked for it, in place of an old one.
///
/// # Errors
/// Exit code 2 if it is no place for a file, or cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let refused = |why: String| Failure::usage(format!("{} cannot be written: {why}", path.display()));
    // A pipe that nobody reads would never be opened.
    if let Ok(data) = fs::metadata(path) {
        let kind = data.file_type();
        if kind.is_dir() {
            return Err(refused("need a file, got a folder".into()));
        }
        if kind.is_fifo() || kind.is_socket() {
            return Err(refused("need a file, got a pipe or a socket".into()));
        }
    }
    fs::write(path, bytes).map_err(|error| refused(error.to_string()))?;
    tracing::info!("wrote {}", path.display());
    Ok(())
}

/// Writes a picture as the ending of its file says: as SVG, or as PDF, which `hopper-figures` makes of it.
///
/// # Errors
/// As [`write`], and exit code 2 if that program is not there.
pub fn write_picture(path: &Path, svg: &str) -> Result<(), Failure> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pdf")) {
        return write(path, svg.as_bytes());
    }
    let failed =
        |error: std::io::Error| Failure::run(format!("the picture cannot be written as PDF: {error}"));
    let mut program = Command::new(tool::sibling("hopper-figures")?);
    let program = program.arg("pdf").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut program = program.spawn().map_err(failed)?;
    if let Some(mut input) = program.stdin.take() {
        input.write_all(svg.as_bytes()).map_err(failed)?;
    }
    let output = program.wait_with_output().map_err(failed)?;
    if !output.status.success() {
        return Err(Failure::run(String::from_utf8_lossy(&output.stderr).trim_end()));
    }
    write(path, &output.stdout)
}
