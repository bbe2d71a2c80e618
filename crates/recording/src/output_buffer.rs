//! The bytes that the MCAP writer has written and the recorder has not returned yet.

use std::cell::RefCell;
use std::io::Write;
use std::rc::Rc;

/// A buffer with two handles: one for the writer, one for the recorder.
#[derive(Clone, Debug, Default)]
pub(crate) struct OutputBuffer(Rc<RefCell<Vec<u8>>>);

impl OutputBuffer {
    /// The bytes written since the last call.
    pub fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.borrow_mut())
    }
}

impl Write for OutputBuffer {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
