//! What the sender of a command knows of the leader.

use contract::{Leader, MonotonicNs};

/// The leader that the sender of a command knows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub leader: Leader,
    /// When the sender first heard of it as such.
    pub since: MonotonicNs,
    /// Whether the sender takes its process for gone.
    pub is_gone: bool,
}
