//! The exit code with which a process ends that cannot use its journal.

use process::{Exit, Failure};

use crate::JournalError;
use crate::file_error::FileError;

impl JournalError {
    /// 4 if another process holds the journal, 1 if the operating system fails, 2 if the journal is
    /// not what the command line says.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            JournalError::Locked { .. } => Exit::Peer,
            JournalError::Io { .. }
            | JournalError::TooLong { .. }
            | JournalError::Displaced { .. }
            | JournalError::OtherAttachment { .. }
            | JournalError::File(FileError::Io { .. }) => Exit::Failed,
            JournalError::File(_)
            | JournalError::Exists { .. }
            | JournalError::Missing { .. }
            | JournalError::BadHeader { .. }
            | JournalError::OlderFormat { .. }
            | JournalError::NewerFormat { .. }
            | JournalError::UnknownField { .. }
            | JournalError::Mismatch { .. }
            | JournalError::Corrupt { .. }
            | JournalError::TornTooMuch { .. }
            | JournalError::Undecodable { .. }
            | JournalError::NotSound { .. }
            | JournalError::NoGround { .. }
            | JournalError::OutOfOrder { .. }
            | JournalError::BrokenChain { .. } => Exit::Usage,
        }
    }
}

impl From<JournalError> for Failure {
    /// A failure with the exit code of the error: 2 of whatever is damaged.
    fn from(error: JournalError) -> Self {
        Failure::new(error.exit(), error.to_string())
    }
}
