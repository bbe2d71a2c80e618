//! Recordings of missions as MCAP files.
//!
//! [`Recorder`] takes every public message and gives bytes to be appended to a file; [`Recording`] reads such a
//! file up to its last valid record, however it was cut; [`recover`] makes a whole file of a cut one. Messages are
//! protobuf, in schemas of our own that mirror the layouts of `contract::wire` field by field ([`proto`]), and, for
//! viewers, in Foxglove's well-known ones ([`view`]). [`Playback`] folds what was sensed, so that another planner
//! can decide it anew.
//!
//! No I/O, no clock: moments are handed in, bytes are handed out. Chunks are not compressed, so that a reader
//! needs no decompressor, which hostile bytes would be fed to.

pub mod error;
pub mod gap;
pub mod host;
mod layout;
pub mod message;
pub mod mirror;
pub mod playback;
pub mod proto;
pub mod reader;
pub mod recorder;
pub mod recovery;
mod shared;
pub mod steps;
pub mod topic;
pub mod view;

pub use error::RecordingError;
pub use gap::{Gap, Gaps};
pub use host::Host;
pub use message::Message;
pub use playback::{Playback, Posed};
pub use reader::{Entry, Recording};
pub use recorder::{Context, Recorder, Wanted};
pub use recovery::recover;
pub use steps::{Flown, steps};
pub use topic::Topic;
