//! Data on standard output.

use std::io::{self, ErrorKind, Write};

use node::Failure;
use serde::Serialize;

/// Writes `text` to standard output. A reader that closes the pipe early, as `head` does, is no error.
///
/// # Errors
/// If standard output cannot be written for any other reason.
pub fn print(text: &str) -> Result<(), Failure> {
    stream(|out| out.write_all(text.as_bytes()))
}

/// Writes `value` as JSON on one line; see [`print()`].
///
/// # Errors
/// If `value` has no JSON form or standard output cannot be written.
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    print(&(serde_json::to_string(value).map_err(Failure::run)? + "\n"))
}

/// Why standard output cannot be written.
#[must_use]
pub fn unwritten(error: &io::Error) -> Failure {
    Failure::run(format!("standard output cannot be written: {error}"))
}

/// Lets `write` write to standard output piece by piece, for output that may be too long for memory; see [`print()`].
///
/// # Errors
/// If standard output cannot be written.
pub fn stream(write: impl FnOnce(&mut io::StdoutLock<'static>) -> io::Result<()>) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|error| unwritten(&error)),
    }
}
