//! How a process ends, and what it says when it cannot go on.

use std::process::{ExitCode, Termination};

/// Exit codes, the same for every command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All went as asked.
    Done = 0,
    /// The work itself failed; of hopper-sim: the mission did not reach its goal.
    Failed = 1,
    /// The command line, a scenario or a file of the user's is at fault.
    Usage = 2,
    /// A limit that was asked for is broken.
    Threshold = 3,
    /// A peer is missing, or holds what only one may hold.
    Peer = 4,
    /// Interrupted by a signal, or by the end of the parent.
    Interrupted = 130,
}

impl Exit {
    /// The number the shell sees.
    #[must_use]
    pub fn code(self) -> u8 {
        self as u8
    }
}

impl Termination for Exit {
    fn report(self) -> ExitCode {
        ExitCode::from(self.code())
    }
}

/// Why a process cannot go on, with the exit code that tells it to scripts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    /// What the process tells whoever started it.
    pub exit: Exit,
    /// One line for the reader.
    pub message: String,
}

impl Failure {
    /// A failure with an exit code of its own.
    #[must_use]
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: in_words(message.into()) }
    }

    /// A failure of the work itself: exit code 1.
    #[must_use]
    pub fn run(error: impl std::fmt::Display) -> Self {
        Self::new(Exit::Failed, error.to_string())
    }

    /// A failure of what the user gave: exit code 2.
    #[must_use]
    pub fn usage(error: impl std::fmt::Display) -> Self {
        Self::new(Exit::Usage, error.to_string())
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::run(error)
    }
}

/// `message` without the numbers that Rust puts behind the words of the operating system: ` (os error 2)`.
fn in_words(mut message: String) -> String {
    const MARK: &str = " (os error ";
    let mut from = 0;
    while let Some(at) = message[from..].find(MARK).map(|at| from + at) {
        let number = &message[at + MARK.len()..];
        match number.find(|letter: char| !letter.is_ascii_digit()) {
            Some(digits) if digits > 0 && number[digits..].starts_with(')') => {
                message.replace_range(at..at + MARK.len() + digits + 1, "");
                from = at;
            }
            _ => from = at + MARK.len(),
        }
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_has_the_words_of_the_operating_system_without_its_number() {
        let error = std::io::Error::from_raw_os_error(2);
        let said = |text: String| Failure::run(text).message;
        assert_eq!(
            said(format!("a: {error}; b: {error}")),
            "a: No such file or directory; b: No such file or directory"
        );
        for kept in ["", "a (os error )", "a (os error 2", "a (os error x)", "ä (os error 2) (os error "] {
            assert_eq!(said(kept.replace(" (os error 2)", "")), kept.replace(" (os error 2)", ""));
        }
    }
}
