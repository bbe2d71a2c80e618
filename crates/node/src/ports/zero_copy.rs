//! The wrapper that lets a wire type through the middleware.

use std::fmt;

use contract::wire::Wire;
use iceoryx2::prelude::ZeroCopySend;

/// A wire type as the middleware sees it: the same bytes, identified by [`Wire::NAME`].
#[repr(transparent)]
#[derive(Clone, Copy)]
pub(crate) struct ZeroCopy<W: Wire>(pub W);

// SAFETY: `Wire` requires `bytemuck::Pod`, so `W` has a fixed layout without padding in which every bit pattern is
// valid; it holds no pointer, reference or handle, and `repr(transparent)` gives `ZeroCopy` exactly that layout. A
// `Wire` is `repr(C)` (or `()`, which has no bytes) and its versioned name stands for one layout only: a changed layout
// takes a new version in the name (contract::wire), which is what `type_name` promises.
unsafe impl<W: Wire> ZeroCopySend for ZeroCopy<W> {
    unsafe fn type_name() -> &'static str {
        W::NAME
    }
}

/// The middleware wants a first value for headers of loaned slots; it is overwritten before sending.
impl<W: Wire> Default for ZeroCopy<W> {
    fn default() -> Self {
        Self(W::zeroed())
    }
}

impl<W: Wire> fmt::Debug for ZeroCopy<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(W::NAME)
    }
}
