//! Files that a command writes into a folder of the user's choice.

use std::fs;
use std::path::Path;

use hopper_sim::private_file::{self, FileError};
use node::Failure;

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
    for (name, text) in files {
        let path = dir.join(name.as_ref());
        private_file::write_shared(&path, text.as_ref()).map_err(|error| match error {
            FileError::Io { path, source, .. } => {
                Failure::run(format!("{} cannot be written: {source}", path.display()))
            }
            refused => Failure::usage(refused),
        })?;
    }
    Ok(())
}
