//! The `main` of every executable.

use std::io::Write;
use std::process::{ExitCode, Termination};

use process::{Exit, Failure};

use crate::log::log_to_stderr;

/// Sends log lines to standard error, runs `run`, and exits with its code. A failure is reported in one line.
pub fn main(role: &str, run: impl FnOnce() -> Result<Exit, Failure>) -> ExitCode {
    log_to_stderr(role, 0);
    let exit = run().unwrap_or_else(|failure| {
        // If standard error is closed, nobody can be told.
        let _ = writeln!(std::io::stderr(), "{role}: {failure}");
        failure.exit
    });
    exit.report()
}
