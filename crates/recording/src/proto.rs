//! The schemas: what protobuf makes of the files in `proto/`, committed.

/// Our own messages, field by field those of `contract::wire`.
#[allow(missing_docs, clippy::all, clippy::pedantic, reason = "written by prost-build")]
pub mod hopper {
    include!("../proto/hopper.rs");
}

/// Foxglove's well-known messages.
#[allow(missing_docs, clippy::all, clippy::pedantic, reason = "written by prost-build")]
pub mod foxglove {
    include!("../proto/foxglove.rs");
}

/// Descriptors of [`hopper`].
pub const HOPPER: &[u8] = include_bytes!("../proto/hopper.bin");

/// Descriptors of [`foxglove`].
pub const FOXGLOVE: &[u8] = include_bytes!("../proto/foxglove.bin");
