//! Freeing what processes left behind that died, at any moment, in the middle of anything.

mod cleanup_thread;
mod creation_lock;
mod dead_node_cleanup;
mod unfinished;

pub(crate) use cleanup_thread::CleanupThread;
pub(crate) use creation_lock::CreationLock;
pub(crate) use dead_node_cleanup::clean_up_dead_nodes;

use std::path::PathBuf;

use crate::lock_holder::LockHolder;
use crate::membership::instance::Instance;
use crate::waiting::holder_of;

impl Instance {
    /// The process that holds the others up at present, if one does: it makes something in the instance, or frees what the dead
    /// left behind. Usually that takes milliseconds; a process that was stopped meanwhile does not end it.
    #[must_use]
    pub fn held_up_by(&self) -> Option<LockHolder> {
        [creation_lock::FILE, dead_node_cleanup::LOCK]
            .into_iter()
            .find_map(|file| holder_of(&self.root().join(file)))
    }

    /// The file whose lock is the right to free what the dead left behind.
    pub(crate) fn cleanup_lock(&self) -> PathBuf {
        self.root().join(dead_node_cleanup::LOCK)
    }
}
