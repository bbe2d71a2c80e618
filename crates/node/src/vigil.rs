//! Watching for reasons to stop: signals, and the end of the parent.

use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Once};
use std::time::Duration;

use iceoryx2_bb_posix::signal::SignalHandler;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::SigId;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1, SIGXFSZ};

use crate::{Exit, NodeError};

/// Why to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// SIGINT, SIGTERM or SIGHUP.
    Signal,
    /// Standard input closed: the parent that held its other end is gone.
    LifelineCut,
}

const SIGNAL: usize = 1;
const LIFELINE_CUT: usize = 2;

/// How long a process may take to end once its lifeline is cut.
const GRACE: Duration = Duration::from_secs(2);

/// Notices reasons to stop, for as long as it lives; any number may live in one process.
#[derive(Debug)]
pub struct Vigil {
    reason: Arc<AtomicUsize>,
    /// Rings at every reason to stop.
    bell: UnixStream,
    rope: UnixStream,
    hooks: Vec<SigId>,
}

impl Vigil {
    /// Begins to watch for SIGINT, SIGTERM and SIGHUP, which no longer end the process.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn new() -> Result<Self, NodeError> {
        let system = |error| NodeError::system("watch", "signals".as_ref(), error);
        restore_signals().map_err(system)?;
        let (bell, rope) = UnixStream::pair().map_err(system)?;
        bell.set_nonblocking(true).map_err(system)?;
        let reason = Arc::new(AtomicUsize::new(0));
        let mut vigil = Self { reason, bell, rope, hooks: Vec::new() };
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            let reason = Arc::clone(&vigil.reason);
            vigil.hooks.push(signal_hook::flag::register_usize(signal, reason, SIGNAL).map_err(system)?);
            let rope = vigil.rope.try_clone().map_err(system)?;
            vigil.hooks.push(signal_hook::low_level::pipe::register(signal, rope).map_err(system)?);
        }
        Ok(vigil)
    }

    /// Why to stop, if there is a reason.
    #[must_use]
    pub fn stop_requested(&self) -> Option<Stop> {
        match self.reason.load(Ordering::SeqCst) {
            SIGNAL => Some(Stop::Signal),
            LIFELINE_CUT => Some(Stop::LifelineCut),
            _ => None,
        }
    }

    /// From now on the end of standard input is a reason to stop. If the process has not ended 2 s after,
    /// its work loop hangs, and it is ended at once, without tidying up.
    pub fn hold_lifeline(&self) {
        let reason = Arc::clone(&self.reason);
        let watch = self.rope.try_clone().and_then(|mut rope| {
            std::thread::Builder::new().name("lifeline".into()).spawn(move || {
                wait_for_end(&mut std::io::stdin().lock());
                let _ = reason.compare_exchange(0, LIFELINE_CUT, Ordering::SeqCst, Ordering::SeqCst);
                let _ = rope.write(&[1]);
                std::thread::sleep(GRACE);
                signal_hook::low_level::exit(i32::from(Exit::Interrupted.code()));
            })
        });
        if let Err(error) = watch {
            tracing::error!("the end of the parent will go unnoticed: {error}");
        }
    }

    /// Sleeps until there is a new reason to stop, which gives `true`, or until `timeout` has passed.
    pub fn wait(&self, timeout: Duration) -> bool {
        let mut fds = [PollFd::new(&self.bell, PollFlags::IN)];
        sleep(&mut fds, timeout) && self.heard(fds[0].revents())
    }

    /// The descriptor that becomes readable at a reason to stop.
    pub(crate) fn bell(&self) -> BorrowedFd<'_> {
        self.bell.as_fd()
    }

    /// Takes note of the bell, so that it can ring again.
    pub(crate) fn heard(&self, events: PollFlags) -> bool {
        events.contains(PollFlags::IN) && (&self.bell).read(&mut [0; 64]).is_ok_and(|count| count > 0)
    }
}

impl Drop for Vigil {
    fn drop(&mut self) {
        for hook in self.hooks.drain(..) {
            signal_hook::low_level::unregister(hook);
        }
    }
}

/// Sleeps until one of the descriptors is ready, which gives `true`, or until `timeout` has passed.
pub(crate) fn sleep(fds: &mut [PollFd<'_>], timeout: Duration) -> bool {
    let timeout = Timespec::try_from(timeout).unwrap_or(Timespec { tv_sec: 3600, tv_nsec: 0 });
    // A signal cuts the sleep short; what it means has been noted where it belongs.
    poll(fds, Some(&timeout)).is_ok_and(|ready| ready > 0)
}

fn wait_for_end(input: &mut impl Read) {
    loop {
        match input.read(&mut [0; 64]) {
            Ok(0) => return,
            Err(error) if error.kind() != ErrorKind::Interrupted => return,
            _ => {}
        }
    }
}

/// The middleware captures a dozen signals when it first makes a shared memory, ours among them. Let it do
/// so now, before our own handlers go on top, and give the others their usual effect back: a terminal's
/// Ctrl-Z and Ctrl-\ still work.
///
/// SIGXFSZ is taken note of and ignored: a file that may not grow is a full disk, an error of the write rather
/// than the death of the process.
fn restore_signals() -> std::io::Result<()> {
    static ONCE: Once = Once::new();
    let mut result = Ok(());
    ONCE.call_once(|| {
        let _ = SignalHandler::last_signal();
        for signal in [SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1] {
            let always = Arc::new(AtomicBool::new(true));
            if let Err(error) = signal_hook::flag::register_conditional_default(signal, always) {
                result = Err(error);
            }
        }
        if let Err(error) = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))) {
            result = Err(error);
        }
    });
    result
}
