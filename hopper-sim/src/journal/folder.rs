//! What making a journal needs of a folder.

use std::io::{self, ErrorKind};
use std::path::PathBuf;

use super::lock::Lock;
use super::{FILE_NAME, Journal, JournalError, JournalHeader, Storage};

/// Name of a journal whose header is being written.
const DRAFT_NAME: &str = "hops.journal.new";

/// What making a journal needs of a folder, so that a simulated one can lose what was not synced.
pub trait Folder {
    /// Where the bytes of one journal are.
    type File: Storage;

    /// The path by which errors name the file `name`.
    fn path(&self, name: &str) -> PathBuf;

    /// Whether it holds a file `name`.
    fn holds(&self, name: &str) -> bool;

    /// Opens `name`, locked against every other process; makes it if `create`.
    ///
    /// # Errors
    /// If it cannot be opened, must not be used, or is locked.
    fn open(&self, name: &str, create: bool) -> Result<(Self::File, Option<Lock>), JournalError>;

    /// Gives the file `from` the name `to`, which no file has.
    ///
    /// # Errors
    /// [`ErrorKind::AlreadyExists`] if a file has it.
    fn rename(&self, from: &str, to: &str) -> io::Result<()>;

    /// Returns once the names of its files would outlive a loss of power.
    ///
    /// # Errors
    /// If they would not.
    fn sync(&self) -> io::Result<()>;
}

impl<S: Storage> Journal<S> {
    /// A new journal in `folder`.
    ///
    /// # Errors
    /// If the folder already holds a journal, or it cannot be written.
    pub fn create_in(
        folder: &impl Folder<File = S>,
        header: &JournalHeader,
        sync: bool,
    ) -> Result<Self, JournalError> {
        let path = folder.path(FILE_NAME);
        if folder.holds(FILE_NAME) {
            return Err(JournalError::Exists { path });
        }
        let bytes = header.seal()?;
        // Written aside, then renamed: a death in between leaves no journal rather than half a header.
        let (file, lock) = folder.open(DRAFT_NAME, true)?;
        let write = || {
            file.cut(0)?;
            file.write_all_at(&bytes, 0)?;
            if sync {
                file.sync()?;
            }
            folder.rename(DRAFT_NAME, FILE_NAME)?;
            if sync {
                folder.sync()?;
            }
            Ok(())
        };
        write().map_err(|error: io::Error| match error.kind() {
            ErrorKind::AlreadyExists => JournalError::Exists { path: path.clone() },
            _ => super::io("create", &path)(error),
        })?;
        let mut journal = Self::empty(file, path, header, bytes.len(), sync);
        journal.locks.extend(lock);
        Ok(journal)
    }
}
