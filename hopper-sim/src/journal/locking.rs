//! How a journal's locks are taken on a disk.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Write};
use std::path::Path;

use super::{JournalError, LOCK_NAME, Lock};
use crate::private_file;

impl Lock {
    /// Locks `file`, which is at `path`.
    ///
    /// # Errors
    /// [`JournalError::Locked`] names the holder.
    pub(super) fn of(file: &File, path: &Path) -> Result<Self, JournalError> {
        match file.try_lock() {
            // A second descriptor of the same open file, which holds the lock as the first does.
            Ok(()) => Ok(Self { file: file.try_clone().map_err(super::io("lock", path))? }),
            Err(TryLockError::WouldBlock) => {
                let dir = path.parent().unwrap_or(path);
                let pid = private_file::lock_holder(file).or_else(|| signed(&dir.join(LOCK_NAME)));
                Err(JournalError::Locked { dir: dir.into(), pid })
            }
            Err(TryLockError::Error(error)) => Err(super::io("lock", path)(error)),
        }
    }

    /// Takes the lock of `dir` and writes this process's id into it.
    ///
    /// # Errors
    /// [`JournalError::Locked`] names the holder.
    pub(super) fn of_folder(dir: &Path) -> Result<Self, JournalError> {
        let path = dir.join(LOCK_NAME);
        let mut file = private_file::open(&path, true)?;
        let lock = Self::of(&file, &path)?;
        let sign = |file: &mut File| -> io::Result<()> {
            file.set_len(0)?;
            writeln!(file, "{}", std::process::id())
        };
        // On a full disk the lock holds all the same; only the holder's name is missing.
        let _ = sign(&mut file);
        Ok(lock)
    }
}

/// The process that wrote itself down in the lock's file at `path`.
fn signed(path: &Path) -> Option<u32> {
    let mut text = String::new();
    // Unreadable or empty: the holder has not written itself down yet.
    File::open(path).ok()?.take(16).read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}
