//! Files that only their owner writes: how they are opened, and which ones are refused. Those of a mission only their owner
//! reads, too.
//!
//! Whoever can place a file or a symbolic link where this process writes next decides what is read back, or which of
//! the owner's other files is overwritten. So no symbolic link is followed, and neither a file nor a folder of another
//! user is used.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::OFlags;

pub use crate::file_error::FileError;

/// Opens `path` for reading and writing; makes it, for its owner only, if `create`. Nothing in it is changed.
///
/// # Errors
/// If it is a symbolic link, no regular file, or another user's; or cannot be opened.
pub fn open(path: &Path, create: bool) -> Result<File, FileError> {
    open_with(path, create, 0o600)
}

/// As [`open`], but a file that is made can be read by whomever the umask allows: results to share.
///
/// # Errors
/// As [`open`].
pub fn open_shared(path: &Path) -> Result<File, FileError> {
    open_with(path, true, 0o666)
}

fn open_with(path: &Path, create: bool, mode: u32) -> Result<File, FileError> {
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .create(create)
        .truncate(false)
        .mode(mode)
        .custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32)
        .open(path);
    let checked = opened.and_then(|file| Ok((file.metadata()?, file)));
    match checked {
        Ok((data, file)) => {
            check(path, &data)?;
            Ok(file)
        }
        Err(source) => {
            // Where the operating system refuses, what is there says why.
            if let Ok(data) = fs::symlink_metadata(path) {
                check(path, &data)?;
            }
            Err(FileError::Io { action: "open", path: path.into(), source })
        }
    }
}

/// Opens `path` for writing and empties it; makes it, for its owner only, if need be.
///
/// # Errors
/// As [`open`].
pub fn create(path: &Path) -> Result<File, FileError> {
    empty(path, open(path, true)?)
}

/// Writes `text` to `path` in place of what was there; a file that is made can be read by whomever the umask allows.
///
/// # Errors
/// As [`open`], or if it cannot be written.
pub fn write_shared(path: &Path, text: &str) -> Result<(), FileError> {
    let mut file = empty(path, open_shared(path)?)?;
    let written = file.write_all(text.as_bytes());
    written.map_err(|source| FileError::Io { action: "write", path: path.into(), source })
}

/// Not by a flag when it is opened: what is refused stays as it is.
fn empty(path: &Path, file: File) -> Result<File, FileError> {
    file.set_len(0).map_err(|source| FileError::Io { action: "empty", path: path.into(), source })?;
    Ok(file)
}

/// Refuses what is at `path` if it is a symbolic link, no regular file, or another user's. Nothing there is fine.
///
/// # Errors
/// If it is, or cannot be looked at.
pub fn check_file(path: &Path) -> Result<(), FileError> {
    match fs::symlink_metadata(path) {
        Ok(data) => check(path, &data),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(source) => Err(FileError::Io { action: "look at", path: path.into(), source }),
    }
}

/// Makes the folder `path` and those above it, for their owner only, unless it exists.
///
/// # Errors
/// If it cannot be made, or is another user's.
pub fn create_folder(path: &Path) -> Result<(), FileError> {
    DirBuilder::new().recursive(true).mode(0o700).create(path).map_err(|source| FileError::Io {
        action: "make",
        path: path.into(),
        source,
    })?;
    check_folder(path)
}

/// Refuses the folder `path` if it is another user's.
///
/// # Errors
/// If it is, or cannot be looked at.
pub fn check_folder(path: &Path) -> Result<(), FileError> {
    let data = fs::metadata(path).map_err(|source| FileError::Io {
        action: "look at",
        path: path.into(),
        source,
    })?;
    check_owner(path, &data)
}

/// The process that holds the lock on `file`; `None` if nobody does, or the operating system does not say.
#[must_use]
pub fn lock_holder(file: &File) -> Option<u32> {
    let data = file.metadata().ok()?;
    let (device, inode) = (data.dev(), data.ino());
    let place = format!("{:02x}:{:02x}:{inode}", rustix::fs::major(device), rustix::fs::minor(device));
    // 1: FLOCK  ADVISORY  WRITE 1234 fd:00:5678 0 EOF
    fs::read_to_string("/proc/locks").ok()?.lines().find_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let holds = words.get(1) == Some(&"FLOCK") && words.get(5) == Some(&place.as_str());
        if !holds {
            return None;
        }
        words.get(4)?.parse().ok().filter(|pid| *pid != 0)
    })
}

fn check(path: &Path, data: &fs::Metadata) -> Result<(), FileError> {
    let kind = data.file_type();
    if kind.is_symlink() {
        return Err(FileError::SymbolicLink { path: path.into(), owner: data.uid() });
    }
    check_owner(path, data)?;
    let got = if kind.is_dir() {
        "a folder"
    } else if kind.is_fifo() {
        "a pipe"
    } else {
        "a device or a socket"
    };
    if kind.is_file() { Ok(()) } else { Err(FileError::NoFile { path: path.into(), got }) }
}

fn check_owner(path: &Path, data: &fs::Metadata) -> Result<(), FileError> {
    let (need, got) = (rustix::process::geteuid().as_raw(), data.uid());
    if need == got { Ok(()) } else { Err(FileError::ForeignOwner { path: path.into(), need, got }) }
}
