//! Why a file or folder that others may have placed is not used.

use std::io;
use std::path::PathBuf;

/// Why a file or folder is not used.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Another user owns it.
    #[error("{} belongs to user {got}, and this process is user {need}: name another folder, or remove it", path.display())]
    ForeignOwner {
        /// The file or folder.
        path: PathBuf,
        /// Number of our user.
        need: u32,
        /// Number of its owner.
        got: u32,
    },
    /// It is a link, which may lead anywhere.
    #[error("{} needs to be a file, got a symbolic link of user {owner}: remove it", path.display())]
    SymbolicLink {
        /// The link.
        path: PathBuf,
        /// Number of the user who made it.
        owner: u32,
    },
    /// It is a folder, a pipe or a device.
    #[error("{} needs to be a file, got {got}", path.display())]
    NoFile {
        /// Where a file was expected.
        path: PathBuf,
        /// What is there instead.
        got: &'static str,
    },
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
}
