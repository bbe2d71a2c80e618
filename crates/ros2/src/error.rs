//! Errors of conversions.

use recording::RecordingError;

/// Why a recording cannot become a bag.
#[derive(Debug, thiserror::Error)]
pub enum Ros2Error {
    /// It has no mission, or is damaged.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// It has a mission, but nothing that was seen of the ground.
    #[error(
        "a bag needs a map, got a recording with none that is whole on hop/map or hop/snapshot among its {messages} messages; record while perception runs"
    )]
    NoMap {
        /// Number of messages that were read.
        messages: u64,
    },
    /// The MCAP writer failed.
    #[error("writing the bag: {0}")]
    Write(#[from] mcap::McapError),
    /// A message cannot be encoded.
    #[error("encoding {name}: {cause}")]
    Encode {
        /// Its type.
        name: &'static str,
        /// What is wrong with it.
        cause: cdr_encoding::Error,
    },
}
