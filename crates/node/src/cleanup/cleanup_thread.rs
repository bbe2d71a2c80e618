//! The thread that frees what dead processes left behind, away from the work loop.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use contract::Role;

use super::creation_lock::CreationLock;
use super::dead_node_cleanup::clean_up_dead_nodes;
use crate::error::NodeError;
use crate::membership::instance::Instance;

/// Cleans up periodically until it is dropped.
#[derive(Debug)]
pub(crate) struct CleanupThread {
    /// Dropping it ends the thread.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Time between two clean-ups: hopper-sim does the work, the others replace it while it is dead.
fn period(role: Option<Role>) -> Duration {
    match role {
        Some(Role::HopperSim) => Duration::from_millis(100),
        _ => Duration::from_secs(1),
    }
}

impl CleanupThread {
    pub(crate) fn start(instance: &Instance, role: Option<Role>) -> Result<Self, NodeError> {
        let config = instance.config();
        let creation_lock = CreationLock::open(instance)?;
        let (stop, stopped) = channel::<()>();
        let thread = std::thread::Builder::new()
            .name("cleanup".into())
            .spawn(move || {
                while stopped.recv_timeout(period(role)) == Err(RecvTimeoutError::Timeout) {
                    if let Ok(Some(guard)) = creation_lock.try_hold() {
                        guard.remove_unfinished();
                    }
                    let freed = clean_up_dead_nodes(&config);
                    if freed > 0 {
                        tracing::info!("freed what {freed} dead process(es) left behind");
                    }
                }
            })
            .map_err(|error| NodeError::system("start", "cleanup thread".as_ref(), error))?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for CleanupThread {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
