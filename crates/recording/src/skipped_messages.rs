//! Counts the messages that a reader cannot decode.

use std::fmt;

use crate::RecordingError;

/// Messages that cannot be decoded. Readers leave them out and report them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SkippedMessages {
    /// Number of skipped messages.
    pub messages: u64,
    /// The first skipped message, with what is wrong; `None` if there is none.
    pub first: Option<String>,
}

impl SkippedMessages {
    /// Counts a message that was left out because of `error`.
    pub fn add(&mut self, error: &RecordingError) {
        self.messages += 1;
        self.first.get_or_insert_with(|| error.to_string());
    }

    /// Passes a decoded message on, and counts one that cannot be decoded.
    pub fn skip<T>(&mut self, message: Result<T, RecordingError>) -> Option<T> {
        message.inspect_err(|error| self.add(error)).ok()
    }

    /// Whether every message was decoded.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.messages == 0
    }
}

impl fmt::Display for SkippedMessages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.messages == 1 { "message" } else { "messages" };
        write!(f, "{} {plural} cannot be decoded", self.messages)?;
        match &self.first {
            Some(first) => write!(f, "; the first is {first}"),
            None => Ok(()),
        }
    }
}
