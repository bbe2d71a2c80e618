//! A disk in memory.

use std::cell::RefCell;
use std::io::{self, ErrorKind};

use hopper_sim::Storage;

/// The bytes of one file.
#[derive(Debug, Default)]
pub struct Disk(RefCell<Vec<u8>>);

impl Disk {
    /// A file of these bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self(RefCell::new(bytes.to_vec()))
    }
}

impl Storage for &Disk {
    fn bytes(&self) -> io::Result<u64> {
        Ok(self.0.borrow().len() as u64)
    }

    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        let bytes = self.0.borrow();
        let from = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
        let from = from.and_then(|bytes| bytes.get(..buffer.len()));
        buffer.copy_from_slice(from.ok_or(ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let mut file = self.0.borrow_mut();
        let (offset, until) = (offset as usize, offset as usize + bytes.len());
        if file.len() < until {
            file.resize(until, 0);
        }
        file[offset..until].copy_from_slice(bytes);
        Ok(())
    }

    fn cut(&self, bytes: u64) -> io::Result<()> {
        self.0.borrow_mut().truncate(bytes as usize);
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        Ok(())
    }
}

impl Disk {
    /// The bytes that were written and not cut off.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.0.into_inner()
    }
}
