//! The folder of a journal on a disk, and how a journal gets its place there.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustix::fs::{CWD, RenameFlags, renameat_with};
use rustix::io::Errno;
use terrain::Terrain;

use super::lock::Lock;
use super::storage::is_at;
use super::{FILE_NAME, Folder, Journal, JournalError, JournalHeader};
use crate::private_file;

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

    /// Opens the journal in `dir` and cuts a torn tail; [`Journal::torn_bytes`] says how much. Whoever is to fly on from it
    /// resumes it: here no record is executed again.
    ///
    /// # Errors
    /// If there is none, it is held by another process, another user's, damaged, or not consecutive.
    pub fn open(dir: &Path, sync: bool) -> Result<Self, JournalError> {
        Self::open_if(dir, sync, None, |_| Ok(()))
    }

    /// Opens the journal of the mission that `expected` describes, on `terrain`; its own run nonce stays in force. Every
    /// record is executed again, and must come out as it is written.
    ///
    /// # Errors
    /// As [`Journal::open`]; [`JournalError::Mismatch`] if the journal found is another mission's, and
    /// [`JournalError::NotSound`] if its records cannot have been flown. It is then left as it is.
    pub fn resume(
        dir: &Path,
        expected: &JournalHeader,
        terrain: &Arc<Terrain>,
        sync: bool,
    ) -> Result<Self, JournalError> {
        Self::open_if(dir, sync, Some(terrain), |header| expected.check(header))
    }

    /// As [`Journal::resume`], of the very run of `expected`.
    ///
    /// # Errors
    /// As [`Journal::resume`]; [`JournalError::Mismatch`] if the journal found is another run's.
    pub fn resume_run(
        dir: &Path,
        expected: &JournalHeader,
        terrain: &Arc<Terrain>,
        sync: bool,
    ) -> Result<Self, JournalError> {
        Self::open_if(dir, sync, Some(terrain), |header| {
            expected.check(header)?;
            let (need, got) = (expected.run().to_string(), header.run().to_string());
            if need == got { Ok(()) } else { Err(JournalError::Mismatch { field: "run".into(), need, got }) }
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
        terrain: Option<&Arc<Terrain>>,
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
        let mut journal = Self::read(file, path, sync, terrain, allowed)?.holding(folder_lock);
        journal.locks.extend(lock);
        Ok(journal)
    }

    fn holding(mut self, lock: Lock) -> Self {
        self.locks.push(lock);
        self
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
