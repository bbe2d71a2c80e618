//! The thread that frees what dead processes left behind, off the hot path.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use contract::Role;

use crate::scaffold::Scaffold;
use crate::undertaker::free_the_dead;
use crate::{Instance, NodeError};

/// Works until it is dropped.
#[derive(Debug)]
pub(crate) struct Janitor {
    /// Its end tells the thread to end.
    leash: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// How often to look: hopper-sim does the work, the others stand in for it while it is dead.
fn period(role: Option<Role>) -> Duration {
    match role {
        Some(Role::HopperSim) => Duration::from_millis(100),
        _ => Duration::from_secs(1),
    }
}

impl Janitor {
    pub(crate) fn start(instance: &Instance, role: Option<Role>) -> Result<Self, NodeError> {
        let config = instance.config();
        let scaffold = Scaffold::open(instance)?;
        let (leash, pull) = channel::<()>();
        let thread = std::thread::Builder::new()
            .name("janitor".into())
            .spawn(move || {
                while pull.recv_timeout(period(role)) == Err(RecvTimeoutError::Timeout) {
                    if let Ok(Some(hold)) = scaffold.try_hold() {
                        hold.clear_unfinished();
                    }
                    let freed = free_the_dead(&config);
                    if freed > 0 {
                        tracing::info!("freed what {freed} dead process(es) left behind");
                    }
                }
            })
            .map_err(|error| NodeError::system("start", "janitor".as_ref(), error))?;
        Ok(Self { leash: Some(leash), thread: Some(thread) })
    }
}

impl Drop for Janitor {
    fn drop(&mut self) {
        self.leash = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
