//! What a journal needs of a disk, so that a simulated one can fail as no real one will on demand.

use std::fmt;
use std::fs::File;
use std::io;
use std::path::Path;

/// Where a path leads, seen from a file that was opened there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Located {
    /// To the very file.
    Here {
        /// Bytes held.
        bytes: u64,
    },
    /// To something else.
    Elsewhere,
    /// To nothing.
    Nowhere,
}

/// Bytes at offsets that outlive the process.
pub trait Storage: fmt::Debug {
    /// Bytes held.
    ///
    /// # Errors
    /// If it cannot be asked.
    fn bytes(&self) -> io::Result<u64>;

    /// Fills `buffer` from `offset` on.
    ///
    /// # Errors
    /// [`io::ErrorKind::UnexpectedEof`] if there are fewer bytes.
    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()>;

    /// Writes `bytes` from `offset` on.
    ///
    /// # Errors
    /// If not all could be written; then any number of them may have been.
    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()>;

    /// Cuts off everything from byte `bytes` on.
    ///
    /// # Errors
    /// If it cannot be cut.
    fn cut(&self, bytes: u64) -> io::Result<()>;

    /// Returns once all that was written would outlive a loss of power.
    ///
    /// # Errors
    /// If it would not.
    fn sync(&self) -> io::Result<()>;

    /// Where `path`, at which it was opened, leads now. Storage that has no path is always there.
    ///
    /// # Errors
    /// If it cannot be looked at.
    fn locate(&self, _path: &Path) -> io::Result<Located> {
        Ok(Located::Here { bytes: self.bytes()? })
    }
}

/// Whether `path` leads to this very file.
#[cfg(unix)]
pub(super) fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    Ok(matches!(file.locate(path)?, Located::Here { .. }))
}

#[cfg(unix)]
impl Storage for File {
    fn bytes(&self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }

    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(self, buffer, offset)
    }

    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::write_all_at(self, bytes, offset)
    }

    fn cut(&self, bytes: u64) -> io::Result<()> {
        self.set_len(bytes)
    }

    fn sync(&self) -> io::Result<()> {
        self.sync_data()
    }

    fn locate(&self, path: &Path) -> io::Result<Located> {
        use std::os::unix::fs::MetadataExt;

        let own = self.metadata()?;
        let found = match std::fs::symlink_metadata(path) {
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                return Ok(Located::Nowhere);
            }
            found => found?,
        };
        let identity = |data: &std::fs::Metadata| (data.dev(), data.ino());
        Ok(match identity(&own) == identity(&found) {
            true => Located::Here { bytes: own.len() },
            false => Located::Elsewhere,
        })
    }
}

/// A journal in a file needs Unix. Elsewhere every access is refused.
#[cfg(not(unix))]
impl Storage for File {
    fn bytes(&self) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn read_exact_at(&self, _buffer: &mut [u8], _offset: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn write_all_at(&self, _bytes: &[u8], _offset: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn cut(&self, _bytes: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn sync(&self) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
}
