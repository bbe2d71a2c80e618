//! Records missions as MCAP files and reads them back.
//!
//! [`Recorder`] takes every public message and returns bytes to append to a file; what it writes on which channel is
//! decided by [`Transcript`], which a live connection shares with it. [`Recording`] reads such a file
//! up to its last valid record, even if it was cut; [`recover`] turns a cut file into a complete one. Messages are
//! protobuf: in our own schemas, which match the layouts of `contract::wire` field by field ([`proto`]), and, for
//! viewers, in Foxglove's well-known schemas ([`view`]); a message without a schema of ours is JSON ([`JsonMessage`]).
//! [`Playback`] replays the observations, so that another
//! planner can decide on them. [`last_run()`] gathers the timing of every decision.
//!
//! No I/O, no clock: times are arguments, bytes are results. Chunks are written uncompressed; those that another program
//! has compressed are read ([`compression`]).

#![warn(clippy::disallowed_methods)]

mod announced_routes;
pub mod channel;
pub mod compression;
pub mod conversion;
mod definitions;
mod earlier_brief;
pub mod entry;
pub mod error;
pub mod json_message;
pub mod last_run;
mod layout;
pub mod machine_load;
pub mod message;
mod output_buffer;
pub mod playback;
pub mod proto;
pub mod reader;
pub mod recorder;
pub mod recovery;
pub mod run_metadata;
pub mod sequence_gap;
pub mod skipped_messages;
pub mod transcript;
pub mod view;
mod waiting_records;

pub use channel::Channel;
pub use entry::Entry;
pub use error::{MessageError, RecordingError};
pub use json_message::JsonMessage;
pub use last_run::{RecordedRun, last_run};
pub use machine_load::MachineLoad;
pub use message::RecordedMessage;
pub use playback::{PendingDecision, Playback};
pub use reader::Recording;
pub use recorder::{Context, Recorder};
pub use recovery::recover;
pub use run_metadata::RunMetadata;
pub use sequence_gap::{SequenceGap, SequenceGaps};
pub use skipped_messages::SkippedMessages;
pub use transcript::{EncodedMessage, Requests, Topic, Transcript};
