//! Freeing what processes left behind that died, at any moment, in the middle of anything.

mod cleanup_thread;
mod creation_lock;
mod dead_node_cleanup;
mod unfinished;

pub(crate) use cleanup_thread::CleanupThread;
pub(crate) use creation_lock::CreationLock;
pub(crate) use dead_node_cleanup::clean_up_dead_nodes;
