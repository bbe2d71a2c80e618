//! Memory that Rust writes and Python can only read.

use std::ffi::{c_int, c_void};
use std::sync::atomic::{AtomicU8, AtomicU16, AtomicU64, Ordering};

use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;

/// Cells of an array. It gives no writable buffer, so NumPy refuses `setflags(write=True)` on whatever is made of it.
#[pyclass(frozen, module = "hopper._native")]
pub struct Memory(Cells);

enum Cells {
    Float64(Box<[AtomicU64]>),
    Byte(Box<[AtomicU8]>),
    Uint16(Box<[AtomicU16]>),
}

/// A number that cells may hold.
pub trait Number: Copy {
    /// NumPy's name of the type.
    const KIND: &'static str;
    /// `count` cells of this number.
    fn memory(self, count: usize) -> Memory;
    /// Writes the cell at `index`, if there is one of this type.
    fn write(self, memory: &Memory, index: usize);
}

impl Number for f64 {
    const KIND: &'static str = "f8";

    fn memory(self, count: usize) -> Memory {
        Memory(Cells::Float64((0..count).map(|_| AtomicU64::new(self.to_bits())).collect()))
    }

    fn write(self, memory: &Memory, index: usize) {
        if let Cells::Float64(cells) = &memory.0 {
            cells[index].store(self.to_bits(), Ordering::Relaxed);
        }
    }
}

impl Number for bool {
    const KIND: &'static str = "?";

    fn memory(self, count: usize) -> Memory {
        Memory(Cells::Byte((0..count).map(|_| AtomicU8::new(self.into())).collect()))
    }

    fn write(self, memory: &Memory, index: usize) {
        if let Cells::Byte(cells) = &memory.0 {
            cells[index].store(self.into(), Ordering::Relaxed);
        }
    }
}

impl Number for u16 {
    const KIND: &'static str = "u2";

    fn memory(self, count: usize) -> Memory {
        Memory(Cells::Uint16((0..count).map(|_| AtomicU16::new(self)).collect()))
    }

    fn write(self, memory: &Memory, index: usize) {
        if let Cells::Uint16(cells) = &memory.0 {
            cells[index].store(self, Ordering::Relaxed);
        }
    }
}

#[pymethods]
impl Memory {
    /// A view of the bytes, never writable.
    ///
    /// # Safety
    /// As the buffer protocol asks: `view` is a buffer to be filled in.
    unsafe fn __getbuffer__(slf: Bound<'_, Self>, view: *mut ffi::Py_buffer, flags: c_int) -> PyResult<()> {
        if flags & ffi::PyBUF_WRITABLE == ffi::PyBUF_WRITABLE {
            return Err(PyBufferError::new_err("the arrays of a map are read-only: change array.copy()"));
        }
        let (start, bytes): (*const c_void, usize) = match &slf.get().0 {
            Cells::Float64(cells) => (cells.as_ptr().cast(), size_of_val(&**cells)),
            Cells::Byte(cells) => (cells.as_ptr().cast(), size_of_val(&**cells)),
            Cells::Uint16(cells) => (cells.as_ptr().cast(), size_of_val(&**cells)),
        };
        // SAFETY: the view is Python's to fill in, and holds a reference to this object, which never moves or drops its cells
        // before. Atomics lie in memory as their integers do, and Rust writes them while Python reads.
        let filled =
            unsafe { ffi::PyBuffer_FillInfo(view, slf.as_ptr(), start.cast_mut(), bytes as isize, 1, flags) };
        if filled == 0 { Ok(()) } else { Err(PyErr::fetch(slf.py())) }
    }
}
