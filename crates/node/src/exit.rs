//! The `main` of every executable.

use std::io::Write;
use std::process::{ExitCode, Termination};

use process::{Exit, Failure};
use rustix::process::{Resource, getrlimit};

use crate::log::log_to_stderr;

/// Least stack of the main thread, bytes: several times what a mission has been seen to take.
const STACK_BYTES_MIN: u64 = 1 << 20;

/// Sends log lines to standard error, runs `run`, and exits with its code. A failure is reported in one line.
pub fn main(role: &str, run: impl FnOnce() -> Result<Exit, Failure>) -> ExitCode {
    log_to_stderr(role, 0);
    let exit = check_stack().and_then(|()| run()).unwrap_or_else(|failure| {
        // `hopper run` says itself why it ends its processes.
        let is_told =
            failure.exit == Exit::Interrupted && std::env::args_os().any(|word| word == "--lifeline");
        if !is_told {
            // If standard error is closed, nobody can be told.
            let _ = writeln!(std::io::stderr(), "{role}: {failure}");
        }
        failure.exit
    });
    exit.report()
}

/// A stack that overflows ends the process by a signal, at any moment: one that is too small is refused at the start.
fn check_stack() -> Result<(), Failure> {
    match getrlimit(Resource::Stack).current {
        Some(got) if got < STACK_BYTES_MIN => Err(Failure::run(format!(
            "the stack needs at least {STACK_BYTES_MIN} bytes, got {got}: raise the limit with `ulimit -s`"
        ))),
        _ => Ok(()),
    }
}
