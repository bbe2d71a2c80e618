//! Errors of writing and reading recordings.

use contract::Refusal;

/// Why a recording cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file does not begin like an MCAP file.
    #[error("a recording needs to begin with the eight bytes of an MCAP file, got {got}")]
    Magic {
        /// The first bytes, and the length of the file.
        got: String,
    },
    /// The file is MCAP, but has no mission of Hopper.
    #[error(
        "a recording needs a brief on hop/brief, got {messages} messages without one; record a mission of Hopper"
    )]
    NoBrief {
        /// Number of messages that were read.
        messages: u64,
    },
    /// A message cannot be decoded, or a field is out of range.
    #[error("message {number} on {topic}: {cause}")]
    Message {
        /// Topic of the message.
        topic: String,
        /// Number of the message in the file, from 0.
        number: u64,
        /// What is wrong with it.
        cause: MessageError,
    },
    /// The MCAP writer failed.
    #[error("writing the recording: {0}")]
    Write(#[from] mcap::McapError),
}

/// Why one message cannot be decoded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MessageError {
    /// The bytes are not protobuf of the channel's schema.
    #[error("{0}")]
    Decode(#[from] prost::DecodeError),
    /// A field is out of range.
    #[error("{0}")]
    Refused(Refusal),
    /// The bytes are not JSON, in which messages without a schema are recorded.
    #[error("not JSON: {0}")]
    Json(String),
}

/// Characters of a number from which on it is written with an exponent: damaged numbers have hundreds of digits.
const NUMBER_CHARACTERS_MAX: usize = 20;

impl From<Refusal> for MessageError {
    fn from(mut refusal: Refusal) -> Self {
        if let Refusal::Malformed { got, .. } = &mut refusal
            && got.len() > NUMBER_CHARACTERS_MAX
            && let Ok(number) = got.parse::<f64>()
        {
            *got = format!("{number:e}");
        }
        Self::Refused(refusal)
    }
}
