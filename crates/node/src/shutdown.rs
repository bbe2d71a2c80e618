//! Reasons to stop: signals, and the end of the parent.

use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use iceoryx2_bb_posix::signal::SignalHandler;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::SigId;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1, SIGXFSZ};

use process::Exit;

use crate::error::NodeError;

/// Why a process is asked to end its work loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// SIGINT, SIGTERM, or SIGHUP unless it was ignored when the process began, as under `nohup`.
    Signal,
    /// Standard input closed: the parent that held its other end is gone.
    LifelineClosed,
}

const SIGNAL: usize = 1;
const LIFELINE_CLOSED: usize = 2;

/// How long a process may take to end once its parent is gone.
const GRACE: Duration = Duration::from_secs(2);

/// Notices reasons to stop, for as long as it lives; any number may live in one process.
#[derive(Debug)]
pub struct ShutdownSignal {
    reason: Arc<AtomicUsize>,
    /// Becomes readable at every reason to stop.
    notified: UnixStream,
    /// The other end of `notified`.
    notifier: UnixStream,
    hooks: Vec<SigId>,
}

impl ShutdownSignal {
    /// Starts to watch for SIGINT, SIGTERM and SIGHUP, which no longer end the process. A SIGHUP that was ignored when the process began,
    /// as under `nohup`, stays ignored, for its children too.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn new() -> Result<Self, NodeError> {
        let system = |error| NodeError::system("watch", "signals".as_ref(), error);
        let hangs_up = restore_signals().map_err(system)?;
        let (notified, notifier) = UnixStream::pair().map_err(system)?;
        notified.set_nonblocking(true).map_err(system)?;
        let reason = Arc::new(AtomicUsize::new(0));
        let mut shutdown = Self { reason, notified, notifier, hooks: Vec::new() };
        for signal in [SIGINT, SIGTERM].into_iter().chain(hangs_up.then_some(SIGHUP)) {
            let reason = Arc::clone(&shutdown.reason);
            shutdown.hooks.push(signal_hook::flag::register_usize(signal, reason, SIGNAL).map_err(system)?);
            let notifier = shutdown.notifier.try_clone().map_err(system)?;
            shutdown.hooks.push(signal_hook::low_level::pipe::register(signal, notifier).map_err(system)?);
        }
        Ok(shutdown)
    }

    /// Why to stop, if there is a reason.
    #[must_use]
    pub fn stop_reason(&self) -> Option<StopReason> {
        match self.reason.load(Ordering::SeqCst) {
            SIGNAL => Some(StopReason::Signal),
            LIFELINE_CLOSED => Some(StopReason::LifelineClosed),
            _ => None,
        }
    }

    /// From now on the end of standard input is a reason to stop. If the process has not ended 2 s later, its work loop
    /// hangs, and it is ended at once, without cleaning up.
    pub fn hold_lifeline(&self) {
        let reason = Arc::clone(&self.reason);
        let watch = self.notifier.try_clone().and_then(|mut notifier| {
            std::thread::Builder::new().name("lifeline".into()).spawn(move || {
                wait_for_end(&mut std::io::stdin().lock());
                let _ = reason.compare_exchange(0, LIFELINE_CLOSED, Ordering::SeqCst, Ordering::SeqCst);
                let _ = notifier.write(&[1]);
                std::thread::sleep(GRACE);
                signal_hook::low_level::exit(i32::from(Exit::Interrupted.code()));
            })
        });
        if let Err(error) = watch {
            tracing::error!("cannot watch the parent, so its end will not stop this process: {error}");
        }
    }

    /// Sleeps until there is a new reason to stop, which gives `true`, or until `timeout` has passed.
    pub fn wait(&self, timeout: Duration) -> bool {
        let mut fds = [PollFd::new(&self.notified, PollFlags::IN)];
        sleep(&mut fds, timeout) && self.acknowledge(fds[0].revents())
    }

    /// The descriptor that becomes readable at a reason to stop.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        self.notified.as_fd()
    }

    /// Takes note of a reason to stop, so that the next one is noticed too; `false` if there was none.
    pub(crate) fn acknowledge(&self, events: PollFlags) -> bool {
        events.contains(PollFlags::IN) && (&self.notified).read(&mut [0; 64]).is_ok_and(|count| count > 0)
    }
}

impl Drop for ShutdownSignal {
    fn drop(&mut self) {
        for hook in self.hooks.drain(..) {
            signal_hook::low_level::unregister(hook);
        }
    }
}

/// Sleeps until one of the descriptors is ready, which gives `true`, or until `timeout` has passed.
pub(crate) fn sleep(fds: &mut [PollFd<'_>], timeout: Duration) -> bool {
    let timeout = Timespec::try_from(timeout).unwrap_or(Timespec { tv_sec: 3600, tv_nsec: 0 });
    // A signal cuts the sleep short; its handler has noted what it means.
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

/// Keeps the middleware from changing what signals do. It captures a dozen signals when it first makes a shared memory,
/// ours among them: it does so now, before our own handlers are installed, and the others get their usual effect back,
/// so a terminal's Ctrl-Z and Ctrl-\ still work.
///
/// SIGXFSZ is ignored: a file that may not grow is a full disk, an error of the write rather than the death of the
/// process.
///
/// Whether a hangup shall end the process.
fn restore_signals() -> std::io::Result<bool> {
    static HANGS_UP: OnceLock<Result<bool, ErrorKind>> = OnceLock::new();
    let restored = HANGS_UP.get_or_init(|| {
        let hangs_up = !is_ignored(SIGHUP);
        let _ = SignalHandler::last_signal();
        if !hangs_up {
            // SAFETY: no handler is installed, so nothing of this program runs when the signal comes.
            unsafe { libc::signal(SIGHUP, libc::SIG_IGN) };
        }
        for signal in [SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1] {
            let always = Arc::new(AtomicBool::new(true));
            signal_hook::flag::register_conditional_default(signal, always).map_err(|error| error.kind())?;
        }
        let never = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(SIGXFSZ, never).map_err(|error| error.kind())?;
        Ok(hangs_up)
    });
    restored.map_err(Into::into)
}

/// Whether the process ignores a signal, which it has from its parent before it handles any.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
