//! The lock that keeps a journal to one writer.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Write};
use std::path::Path;

use super::JournalError;

/// Name of the lock's file in the journal's directory.
const FILE_NAME: &str = "lock";

/// Held as long as it lives; the operating system lets go of it when the process dies.
#[derive(Debug)]
pub(super) struct Lock {
    file: File,
}

impl Lock {
    /// Takes the lock of `dir` and writes this process's id into it.
    ///
    /// # Errors
    /// [`JournalError::Locked`] names the holder.
    pub(super) fn acquire(dir: &Path) -> Result<Self, JournalError> {
        let path = dir.join(FILE_NAME);
        let mut file = super::owner_only().create(true).open(&path).map_err(super::io("open", &path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                // Unreadable or empty: the holder has not written itself down yet.
                let _ = file.take(16).read_to_string(&mut text);
                return Err(JournalError::Locked { dir: dir.into(), pid: text.trim().parse().ok() });
            }
            Err(TryLockError::Error(error)) => return Err(super::io("lock", &path)(error)),
        }
        let sign = |file: &mut File| -> io::Result<()> {
            file.set_len(0)?;
            writeln!(file, "{}", std::process::id())
        };
        // On a full disk the lock holds all the same; only the holder's name is missing.
        let _ = sign(&mut file);
        Ok(Self { file })
    }
}

/// Closing the file would not do: a child that another thread has forked and that has not yet come to its
/// exec holds the very same open file, and the lock with it.
impl Drop for Lock {
    fn drop(&mut self) {
        let _ = self.file.unlock();
    }
}
