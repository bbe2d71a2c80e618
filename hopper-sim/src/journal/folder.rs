//! The folder of a journal, and how a journal gets its place there.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use rustix::fs::{CWD, RenameFlags, renameat_with};
use rustix::io::Errno;

use super::lock::Lock;
use super::storage::is_at;
use super::{FILE_NAME, Journal, JournalError, JournalHeader, Storage};
use crate::private_file;

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

/// A folder on a disk.
#[derive(Debug)]
struct Directory<'a>(&'a Path);

impl Folder for Directory<'_> {
    type File = File;

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn holds(&self, name: &str) -> bool {
        fs::symlink_metadata(self.path(name)).is_ok()
    }

    fn open(&self, name: &str, create: bool) -> Result<(File, Option<Lock>), JournalError> {
        let path = self.path(name);
        let file = private_file::open(&path, create)?;
        let lock = Lock::of(&file, &path)?;
        // Whoever had it locked until now may have renamed or removed it.
        if !is_at(&file, &path).map_err(super::io("look at", &path))? {
            return Err(JournalError::Locked { dir: self.0.into(), pid: None });
        }
        Ok((file, Some(lock)))
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        let (from, to) = (self.path(from), self.path(to));
        match renameat_with(CWD, &from, CWD, &to, RenameFlags::NOREPLACE) {
            // A file system that cannot promise it: the folder's lock keeps others away.
            Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) if fs::symlink_metadata(&to).is_err() => {
                fs::rename(&from, &to)
            }
            renamed => Ok(renamed?),
        }
    }

    fn sync(&self) -> io::Result<()> {
        File::open(self.0)?.sync_all()
    }
}

impl Journal {
    /// A new journal in `dir`, which is made if there is none. With `sync` every append reaches the
    /// disk before it counts, so that the journal outlives a loss of power.
    ///
    /// # Errors
    /// If the directory already holds a journal, is held by another process, is another user's, or cannot be written.
    pub fn create(dir: &Path, header: &JournalHeader, sync: bool) -> Result<Self, JournalError> {
        make(dir, sync)?;
        let lock = Lock::of_folder(dir)?;
        Ok(Self::create_in(&Directory(dir), header, sync)?.holding(lock))
    }

    /// Opens the journal in `dir` and cuts a torn tail; [`Journal::torn_bytes`] says how much.
    ///
    /// # Errors
    /// If there is none, it is held by another process, another user's, damaged, or not consecutive.
    pub fn open(dir: &Path, sync: bool) -> Result<Self, JournalError> {
        Self::open_if(dir, sync, |_| Ok(()))
    }

    /// Opens the journal of the mission that `expected` describes; its own run nonce stays in force.
    ///
    /// # Errors
    /// As [`Journal::open`]; [`JournalError::Mismatch`] if the journal found is another mission's,
    /// which is then left as it is.
    pub fn resume(dir: &Path, expected: &JournalHeader, sync: bool) -> Result<Self, JournalError> {
        Self::open_if(dir, sync, |header| expected.check(header))
    }

    /// As [`Journal::resume`], of the very run of `expected`.
    ///
    /// # Errors
    /// As [`Journal::resume`]; [`JournalError::Mismatch`] if the journal found is another run's.
    pub fn resume_run(dir: &Path, expected: &JournalHeader, sync: bool) -> Result<Self, JournalError> {
        Self::open_if(dir, sync, |header| {
            expected.check(header)?;
            let (need, got) = (expected.run().to_string(), header.run().to_string());
            if need == got { Ok(()) } else { Err(JournalError::Mismatch { field: "run", need, got }) }
        })
    }

    /// Whether `dir` holds a journal.
    #[must_use]
    pub fn exists(dir: &Path) -> bool {
        Directory(dir).holds(FILE_NAME)
    }

    fn open_if(
        dir: &Path,
        sync: bool,
        allowed: impl Fn(&JournalHeader) -> Result<(), JournalError>,
    ) -> Result<Self, JournalError> {
        let folder = Directory(dir);
        let path = folder.path(FILE_NAME);
        if !folder.holds(FILE_NAME) {
            return Err(JournalError::Missing { path });
        }
        private_file::check_folder(dir)?;
        // First, so that whoever is refused has changed nothing in the folder.
        let (file, lock) = folder.open(FILE_NAME, false)?;
        let folder_lock = Lock::of_folder(dir)?;
        let mut journal = Self::read(file, path, sync, allowed)?.holding(folder_lock);
        journal.locks.extend(lock);
        Ok(journal)
    }

    fn holding(mut self, lock: Lock) -> Self {
        self.locks.push(lock);
        self
    }
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

/// Makes `dir` if need be, for the owner only. With `sync` its name outlives a loss of power, and so do those of the
/// folders above it that were made with it.
fn make(dir: &Path, sync: bool) -> Result<(), JournalError> {
    let new: Vec<&Path> = dir.ancestors().take_while(|folder| !folder.exists()).collect();
    private_file::create_folder(dir)?;
    for folder in new.into_iter().filter(|folder| sync && !folder.as_os_str().is_empty()) {
        let above = folder.parent().filter(|above| !above.as_os_str().is_empty());
        let above = above.unwrap_or(Path::new("."));
        Directory(above).sync().map_err(super::io("sync", above))?;
    }
    Ok(())
}
