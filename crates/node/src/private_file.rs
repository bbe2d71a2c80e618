//! How this crate opens files of its own: for their owner only, and never through a symbolic link.

use std::fs::OpenOptions;
use std::os::unix::fs::OpenOptionsExt;

use rustix::fs::OFlags;

/// Options for reading and writing a file of mode `mode` if it is made.
pub(crate) fn owner_only(mode: u32) -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true).write(true).mode(mode).custom_flags(OFlags::NOFOLLOW.bits() as i32);
    options
}
