//! The protobuf schemas: generated from the files in `proto/` and committed.

/// Our own messages, with the fields of `contract::wire`.
#[allow(missing_docs, clippy::all, clippy::pedantic, reason = "written by prost-build")]
pub mod hopper {
    include!("../proto/hopper.rs");
}

/// Foxglove's well-known messages, which its viewers display.
#[allow(missing_docs, clippy::all, clippy::pedantic, reason = "written by prost-build")]
pub mod foxglove {
    include!("../proto/foxglove.rs");
}

/// Serialised file descriptor set of [`hopper`].
pub const HOPPER: &[u8] = include_bytes!("../proto/hopper.bin");

/// Serialised file descriptor set of [`foxglove`].
pub const FOXGLOVE: &[u8] = include_bytes!("../proto/foxglove.bin");
