//! A row of numbers that begins at a cache line.

use crate::pages;

/// Numbers whose first lies at a cache line, so that no chunk of a layout lies across two.
#[derive(Debug, Default)]
pub(crate) struct Plane<T> {
    numbers: Vec<T>,
    len: usize,
}

/// Bytes of a cache line.
const LINE_BYTES: usize = 64;

impl<T: Copy + Default> Plane<T> {
    /// Becomes `len` zeros; fresh ones from the system, which cost nothing until touched.
    pub fn reset(&mut self, len: usize) {
        // The old ones go first.
        self.numbers = Vec::new();
        self.numbers = pages::filled(T::default(), len + LINE_BYTES / size_of::<T>());
        self.len = len;
    }

    /// The numbers.
    pub fn all(&self) -> &[T] {
        let start = self.start();
        &self.numbers[start..start + self.len]
    }

    /// The numbers, to be changed.
    pub fn all_mut(&mut self) -> &mut [T] {
        let start = self.start();
        &mut self.numbers[start..start + self.len]
    }

    fn start(&self) -> usize {
        self.numbers.as_ptr().align_offset(LINE_BYTES).min(self.numbers.len() - self.len)
    }
}

impl<T: Copy + Default> Clone for Plane<T> {
    /// The numbers again, which begin elsewhere after the start of their memory.
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.reset(self.len);
        copy.all_mut().copy_from_slice(self.all());
        copy
    }
}
