//! What a journal needs of a disk, so that a simulated one can fail as no real one will on demand.

use std::fmt;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

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
}

impl Storage for File {
    fn bytes(&self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }

    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        FileExt::read_exact_at(self, buffer, offset)
    }

    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        FileExt::write_all_at(self, bytes, offset)
    }

    fn cut(&self, bytes: u64) -> io::Result<()> {
        self.set_len(bytes)
    }

    fn sync(&self) -> io::Result<()> {
        self.sync_data()
    }
}

impl Storage for Box<dyn Storage> {
    fn bytes(&self) -> io::Result<u64> {
        self.as_ref().bytes()
    }

    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        self.as_ref().read_exact_at(buffer, offset)
    }

    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        self.as_ref().write_all_at(bytes, offset)
    }

    fn cut(&self, bytes: u64) -> io::Result<()> {
        self.as_ref().cut(bytes)
    }

    fn sync(&self) -> io::Result<()> {
        self.as_ref().sync()
    }
}
