//! Why a recording cannot be written or read.

use contract::Refusal;

/// What was needed of a recording, and what was got.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The first bytes are not those of an MCAP file.
    #[error("a recording needs to begin with the eight bytes of an MCAP file, got {got}")]
    Magic {
        /// The first bytes, in words.
        got: String,
    },
    /// There is nothing of Hopper in it.
    #[error("a recording needs a brief on hop/brief, got {messages} messages without one: is it of Hopper?")]
    NoBrief {
        /// Messages that were read.
        messages: u64,
    },
    /// A message does not decode, or is out of range.
    #[error("message {number} on {topic}: {cause}")]
    Message {
        /// Its topic.
        topic: String,
        /// Its number in the file, from 0.
        number: u64,
        /// What is wrong.
        cause: MessageError,
    },
    /// The writer refused.
    #[error("writing the recording: {0}")]
    Write(#[from] mcap::McapError),
}

/// What is wrong with one message.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MessageError {
    /// It is no protobuf of its schema.
    #[error("{0}")]
    Decode(#[from] prost::DecodeError),
    /// A field is out of range.
    #[error("{0}")]
    Refused(#[from] Refusal),
}
