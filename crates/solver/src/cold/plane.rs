//! An array of numbers that begins at a cache line.

use crate::pages;

/// Numbers aligned to a cache line, so that no aligned chunk straddles two.
#[derive(Debug, Default)]
pub(crate) struct Plane<T> {
    numbers: Vec<T>,
    len: usize,
}

/// Bytes of a cache line.
const LINE_BYTES: usize = 64;

impl<T: Copy + Default> Plane<T> {
    /// Becomes `len` zeros, in fresh memory, which costs nothing until touched.
    pub fn reset(&mut self, len: usize) {
        // Free the old memory first.
        self.numbers = Vec::new();
        self.numbers = pages::filled(T::default(), len + LINE_BYTES / size_of::<T>());
        self.len = len;
    }

    /// All `len` numbers.
    pub fn all(&self) -> &[T] {
        let start = self.start();
        &self.numbers[start..start + self.len]
    }

    /// All `len` numbers, writable.
    pub fn all_mut(&mut self) -> &mut [T] {
        let start = self.start();
        &mut self.numbers[start..start + self.len]
    }

    fn start(&self) -> usize {
        self.numbers.as_ptr().align_offset(LINE_BYTES).min(self.numbers.len() - self.len)
    }
}

impl<T: Copy + Default> Clone for Plane<T> {
    /// Copies the numbers only, since the alignment offset differs from one allocation to the next.
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.reset(self.len);
        copy.all_mut().copy_from_slice(self.all());
        copy
    }
}
