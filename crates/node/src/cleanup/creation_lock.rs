//! One process at a time makes nodes, services and ports, so that what is half-made belongs to a dead process.
//!
//! The kernel releases the lock of a process that dies, and whoever takes it removes what is unfinished before making
//! anything. Connections between two ports are the exception: they are made whenever the ports meet, outside the lock.
//! An unfinished one is removed when one of its ports is known to be dead: then nobody needs it.

use std::fs::File;
use std::path::PathBuf;
use std::time::Duration;

use rustix::fs::FlockOperation;

use super::unfinished;
use crate::error::NodeError;
use crate::file_lock::{try_flock, unlock};
use crate::membership::instance::Instance;
use crate::private_file::owner_only;
use crate::waiting::Waiting;

pub(super) const FILE: &str = "creation.lock";

/// The right of one process at a time to make things in the instance.
#[derive(Debug)]
pub(crate) struct CreationLock {
    file: File,
    instance: Instance,
}

/// The lock is held until this is dropped.
#[derive(Debug)]
pub(crate) struct CreationGuard<'a>(&'a CreationLock);

impl CreationLock {
    /// Opens the lock; the caller belongs to the instance.
    pub(crate) fn open(instance: &Instance) -> Result<Self, NodeError> {
        let path = instance.root().join(FILE);
        let opened = owner_only(0o600).create(true).truncate(false).open(&path);
        let file = opened.map_err(|error| NodeError::system("open", &path, error))?;
        Ok(Self { file, instance: instance.clone() })
    }

    /// Waits for the lock; making one thing takes milliseconds.
    pub(crate) fn hold(&self, waiting: &Waiting) -> Result<CreationGuard<'_>, NodeError> {
        waiting.until(&self.path(), Duration::from_micros(500), || self.try_hold())
    }

    /// Takes the lock if nobody holds it.
    pub(crate) fn try_hold(&self) -> Result<Option<CreationGuard<'_>>, NodeError> {
        let operation = FlockOperation::NonBlockingLockExclusive;
        Ok(try_flock(&self.file, operation, &self.path())?.then(|| CreationGuard(self)))
    }

    fn path(&self) -> PathBuf {
        self.instance.root().join(FILE)
    }
}

impl CreationGuard<'_> {
    /// Removes what the dead left unfinished.
    pub(crate) fn remove_unfinished(&self) {
        unfinished::remove_all(self.0.instance.root(), &self.0.instance.prefix());
    }

    /// Fails if a file of another user bears the instance's name.
    pub(crate) fn refuse_foreign_files(&self) -> Result<(), NodeError> {
        self.0.instance.refuse_foreign_files()
    }
}

impl Drop for CreationGuard<'_> {
    fn drop(&mut self) {
        unlock(&self.0.file);
    }
}
