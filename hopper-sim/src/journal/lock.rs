//! The locks that keep a journal to one writer.
//!
//! What is locked is the file of the records itself: whoever removes or replaces any other file in the folder lets
//! nobody else in. `lock` is locked too, since builds before this one lock nothing else, and since two processes
//! that begin a journal at once have no file of records yet.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Write};
use std::path::Path;

use super::JournalError;
use crate::private_file;

/// Name of the lock's file in the journal's directory.
pub const LOCK_NAME: &str = "lock";

/// Held as long as it lives; the operating system lets go of it when the process dies.
#[derive(Debug)]
pub struct Lock {
    file: File,
}

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

/// Closing the file would not do: a child that another thread has forked and that has not yet come to its
/// exec holds the very same open file, and the lock with it.
impl Drop for Lock {
    fn drop(&mut self) {
        let _ = self.file.unlock();
    }
}
