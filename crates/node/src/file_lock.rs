//! Locks on files, which the kernel releases when their holder dies.

use std::fs::File;
use std::path::Path;

use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;

use crate::error::NodeError;

/// Takes or changes a lock without waiting; `false` if others hold one that conflicts.
pub(crate) fn try_flock(file: &File, operation: FlockOperation, path: &Path) -> Result<bool, NodeError> {
    loop {
        match flock(file, operation) {
            Ok(()) => return Ok(true),
            Err(Errno::WOULDBLOCK) => return Ok(false),
            Err(Errno::INTR) => {}
            Err(error) => return Err(NodeError::system("lock", path, error)),
        }
    }
}

/// Releases a lock. Closing the file is not enough: a child that another thread has forked and that has not reached
/// its exec yet shares the open file, and keeps the lock with it.
pub(crate) fn unlock(file: &File) {
    let _ = flock(file, FlockOperation::Unlock);
}
