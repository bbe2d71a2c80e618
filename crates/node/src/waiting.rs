//! Waiting for another process of the instance that is in the way.

use std::fs::File;
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use crate::error::NodeError;
use crate::lock_holder::LockHolder;
use crate::shutdown::ShutdownSignal;

/// A wait as long as this is logged: usually a lock is free again after milliseconds.
const WORTH_A_LINE: Duration = Duration::from_secs(1);

/// How long to retry while what is to be made cannot be: a process that makes or removes something does not hold the lock for long.
pub(crate) const PATIENCE: Duration = Duration::from_secs(4);

/// How a process joins.
#[derive(Clone, Copy, Debug)]
pub struct Joining {
    /// How long it waits for a process that is in its way, such as one that was stopped while it joined.
    pub patience: Duration,
    /// Whether the end of standard input is a reason to stop, from the first moment on: see [`ShutdownSignal::hold_lifeline`].
    pub lifeline: bool,
}

impl Joining {
    /// With that patience, and no less than the usual one: on a busy machine the others take seconds to join.
    #[must_use]
    pub fn patiently(patience: Duration) -> Self {
        Self { patience: patience.max(PATIENCE), lifeline: false }
    }

    /// The wait of a process that has not joined yet; a reason to stop ends it.
    pub(crate) fn waiting(self) -> Result<Waiting, NodeError> {
        let shutdown = ShutdownSignal::new()?;
        if self.lifeline {
            shutdown.hold_lifeline();
        }
        Ok(Waiting::new(self.patience, Some(Rc::new(shutdown))))
    }
}

impl Default for Joining {
    fn default() -> Self {
        Self { patience: PATIENCE, lifeline: false }
    }
}

/// How long a process waits for others that are in its way, and what ends the wait before.
#[derive(Clone, Debug)]
pub(crate) struct Waiting {
    patience: Duration,
    /// `None` of one that nobody asks to stop.
    shutdown: Option<Rc<ShutdownSignal>>,
}

impl Waiting {
    /// At most as long as `patience`.
    pub(crate) fn new(patience: Duration, shutdown: Option<Rc<ShutdownSignal>>) -> Self {
        Self { patience, shutdown }
    }

    /// As this one, and no longer than `patience`.
    pub(crate) fn at_most(&self, patience: Duration) -> Self {
        Self { patience: self.patience.min(patience), ..self.clone() }
    }

    /// Calls `attempt` until it gives something, with a pause in between. Meanwhile `lock` is held by another process, which
    /// the log names.
    ///
    /// # Errors
    /// If that takes longer than the patience, or this process is to stop; or the error of `attempt`.
    pub(crate) fn until<T>(
        &self,
        lock: &Path,
        pause: Duration,
        mut attempt: impl FnMut() -> Result<Option<T>, NodeError>,
    ) -> Result<T, NodeError> {
        let mut hold_up = HoldUp::begin();
        loop {
            if let Some(got) = attempt()? {
                return Ok(got);
            }
            self.endure(&mut hold_up, lock)?;
            std::thread::sleep(pause);
        }
    }

    /// Goes on waiting for the holder of `lock`.
    ///
    /// # Errors
    /// If the patience is over, or this process is to stop.
    pub(crate) fn endure(&self, hold_up: &mut HoldUp, lock: &Path) -> Result<(), NodeError> {
        if self.shutdown.as_ref().is_some_and(|shutdown| shutdown.stop_reason().is_some()) {
            return Err(NodeError::Interrupted);
        }
        let waited = hold_up.since.elapsed();
        let is_over = waited > self.patience;
        if !is_over && (hold_up.logged || waited < WORTH_A_LINE) {
            return Ok(());
        }
        let busy = NodeError::Busy {
            path: lock.into(),
            waited_s: (waited.as_secs_f64() * 10.0).round() / 10.0,
            holder: holder_of(lock).map(Box::new),
        };
        if is_over {
            return Err(busy);
        }
        hold_up.logged = true;
        tracing::warn!("waiting: {busy}");
        Ok(())
    }
}

/// One wait.
#[derive(Debug)]
pub(crate) struct HoldUp {
    since: Instant,
    /// Whether the log has named the holder.
    logged: bool,
}

impl HoldUp {
    /// Since now.
    pub(crate) fn begin() -> Self {
        Self { since: Instant::now(), logged: false }
    }
}

/// The process that holds a lock file; `None` if nobody holds it, or nobody knows who.
pub(crate) fn holder_of(lock: &Path) -> Option<LockHolder> {
    LockHolder::of(&File::open(lock).ok()?)
}
