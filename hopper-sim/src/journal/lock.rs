//! The locks that keep a journal to one writer.
//!
//! What is locked is the file of the records itself: whoever removes or replaces any other file in the folder lets
//! nobody else in. `lock` is locked too, since builds before this one lock nothing else, and since two processes
//! that begin a journal at once have no file of records yet.

use std::fs::File;

/// Name of the lock's file in the journal's directory.
pub const LOCK_NAME: &str = "lock";

/// Held as long as it lives; the operating system lets go of it when the process dies.
#[derive(Debug)]
pub struct Lock {
    pub(super) file: File,
}

/// Closing the file would not do: a child that another thread has forked and that has not yet come to its
/// exec holds the very same open file, and the lock with it.
impl Drop for Lock {
    fn drop(&mut self) {
        let _ = self.file.unlock();
    }
}
