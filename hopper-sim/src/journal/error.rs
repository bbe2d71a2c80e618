//! What can go wrong with a journal.

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::path::PathBuf;

use contract::{Decision, Digest};

use crate::file_error::FileError;

/// What became of a journal's file while it was in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Displacement {
    /// Its path leads nowhere: it was deleted, or moved away.
    Gone,
    /// Its path leads to another file.
    Replaced,
    /// Somebody else has cut it or written to it.
    Resized {
        /// Bytes written to it.
        need: u64,
        /// Bytes it holds.
        got: u64,
    },
}

impl fmt::Display for Displacement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gone => f.write_str("was deleted or moved away"),
            Self::Replaced => f.write_str("was replaced by another file"),
            Self::Resized { need, got } if got < need => write!(f, "was cut from {need} to {got} bytes"),
            Self::Resized { need, got } => {
                write!(f, "needs {need} bytes, got {got}: somebody else has written to it")
            }
        }
    }
}

/// Why a journal was not opened, read or written.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// On what.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A file or a folder that must not be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is no longer what its path leads to.
    #[error(
        "{} {displacement} while it was in use: no hop is flown that a restart would fly again; put the very same file \
         back to go on",
        path.display()
    )]
    Displaced {
        /// The journal's path.
        path: PathBuf,
        /// What became of the file.
        displacement: Displacement,
    },
    /// Another process has it.
    #[error("the journal {} is held by {}", dir.display(), holder(*pid))]
    Locked {
        /// The journal's directory.
        dir: PathBuf,
        /// The holder, if it has written itself down.
        pid: Option<u32>,
    },
    /// A new run needs a directory without a journal.
    #[error("a new run needs a directory without a journal, got one at {}", path.display())]
    Exists {
        /// The journal found.
        path: PathBuf,
    },
    /// There is none.
    #[error("needs a journal, got no file {}", path.display())]
    Missing {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// It is something else, or its header is damaged.
    #[error("{} is not a journal or its header is damaged: {reason}", path.display())]
    BadHeader {
        /// The file.
        path: PathBuf,
        /// What about it.
        reason: String,
    },
    /// It was written before the first release.
    #[error(
        "{} is of an older format, which this build does not read: use a build of 25 November 2026 or before (format {format})",
        path.display()
    )]
    OlderFormat {
        /// The file.
        path: PathBuf,
        /// Its format.
        format: u32,
    },
    /// It was written by a later build, in another layout.
    #[error(
        "{} is of a newer format than this build reads: it was written by version {version} (format {format})",
        path.display()
    )]
    NewerFormat {
        /// The file.
        path: PathBuf,
        /// Its format.
        format: u32,
        /// The build that wrote it.
        version: String,
    },
    /// Its header has a field that only other builds know.
    #[error(
        "{} has the field {field} in its header, which this build does not know: it was written by version {version}",
        path.display()
    )]
    UnknownField {
        /// The file.
        path: PathBuf,
        /// Path of the field, such as `brief.guard.deadline_ns`.
        field: String,
        /// The build that wrote it.
        version: String,
    },
    /// It belongs to another mission.
    #[error("the journal is of another mission: {field} needs {need}, got {got}")]
    Mismatch {
        /// The field of the header.
        field: Cow<'static, str>,
        /// What the mission needs.
        need: String,
        /// What the journal has.
        got: String,
    },
    /// A broken frame with whole ones after it: not a torn tail, so nothing is cut.
    #[error("{} is corrupt: the frame at byte {offset} is broken, yet a whole one follows at {whole_at}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// Where the broken frame begins, bytes.
        offset: u64,
        /// Where a whole one follows, bytes.
        whole_at: u64,
    },
    /// More bytes after the last whole frame than a torn write leaves: nothing is cut.
    #[error(
        "{} holds no record at byte {offset}: a torn tail needs at most {max} bytes, got {got}; if they are to go, \
         truncate --size={offset} the file",
        path.display()
    )]
    TornTooMuch {
        /// The file.
        path: PathBuf,
        /// Where the last whole frame ends, bytes.
        offset: u64,
        /// Most bytes of a tail.
        max: u64,
        /// Bytes after the last whole frame.
        got: u64,
    },
    /// A frame is whole but holds no record.
    #[error("{} holds no record at byte {offset}: {reason}", path.display())]
    Undecodable {
        /// The file.
        path: PathBuf,
        /// Where the frame begins, bytes.
        offset: u64,
        /// What about it.
        reason: String,
    },
    /// It can be read, but its records cannot be those of its mission.
    #[error("{} is NOT SOUND: {}; hopper journal show prints what it holds", path.display(), faults.join("; "))]
    NotSound {
        /// The file.
        path: PathBuf,
        /// What is wrong, a sentence each.
        faults: Vec<String>,
    },
    /// The ground that its mission was flown on cannot be had.
    #[error("the ground of {} is not at hand: {reason}", path.display())]
    NoGround {
        /// The file.
        path: PathBuf,
        /// Which file of the ground, and what about it.
        reason: String,
    },
    /// Decisions must follow one another.
    #[error("the journal needs decision {need} next, got {got}")]
    OutOfOrder {
        /// The decision due.
        need: Decision,
        /// The record's.
        got: Decision,
    },
    /// A record that announces a route must come with its points, one that names a detail with that, and no other with anything.
    #[error(
        "the record of decision {decision} needs the route or the detail that it names, got none or another"
    )]
    OtherAttachment {
        /// The decision.
        decision: Decision,
    },
    /// Each record must continue the digest chain.
    #[error("decision {decision} needs to continue digest {need}, got {got}")]
    BrokenChain {
        /// The record's decision.
        decision: Decision,
        /// Digest so far.
        need: Digest,
        /// Digest the record says was before it.
        got: Digest,
    },
    /// A header or record does not fit its frame.
    #[error("a frame needs at most {max} bytes, got {got}")]
    TooLong {
        /// Most bytes.
        max: usize,
        /// Bytes encoded.
        got: usize,
    },
}

fn holder(pid: Option<u32>) -> String {
    pid.map_or_else(|| "another process".into(), |pid| format!("process {pid}"))
}
