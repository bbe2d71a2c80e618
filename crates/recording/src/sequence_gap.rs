//! Detects messages that did not reach the recorder by the sequence numbers that messages carry.

use std::collections::BTreeMap;

use contract::{Decision, Heartbeat, Incarnation, MapPatch, State};

use crate::Channel;

/// Most processes whose heartbeats are counted at once.
const PROCESSES_MAX: usize = 256;

/// Consecutive messages that are missing from a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SequenceGap {
    /// Topic they were published on.
    pub topic: String,
    /// Number of the first missing message.
    pub from: u64,
    /// Number of the last missing message, at least `from`.
    pub through: u64,
    /// What the numbers count, such as "decisions".
    pub counted: String,
}

impl SequenceGap {
    /// Number of missing messages, at least 1.
    #[must_use]
    pub fn missing(&self) -> u64 {
        (self.through - self.from).saturating_add(1)
    }
}

/// Follows the sequence numbers of one run's states and patches, and of heartbeats. Commands have none: they are
/// repeated until answered, so losing one is harmless.
#[derive(Clone, Debug)]
pub struct SequenceGaps {
    /// Next decision expected; the first of a run is 0.
    decision: u64,
    /// Next patch expected; the first of a run is 1.
    sequence: u64,
    /// Last heartbeat counter of each process.
    beats: BTreeMap<Incarnation, u64>,
}

impl Default for SequenceGaps {
    fn default() -> Self {
        Self { decision: 0, sequence: 1, beats: BTreeMap::new() }
    }
}

impl SequenceGaps {
    /// The states missing before `state`; before the first one, those published before recording began. A decision
    /// seen before is a repetition, or follows a journal that lost its tail, and is no gap.
    pub fn state(&mut self, state: &State) -> Option<SequenceGap> {
        let Decision(decision) = state.decision;
        let due = std::mem::replace(&mut self.decision, decision.saturating_add(1));
        gap(Channel::State, due, decision, "decisions")
    }

    /// The patches missing before `patch`; before the first one, those published before recording began.
    pub fn patch(&mut self, patch: &MapPatch) -> Option<SequenceGap> {
        let due = std::mem::replace(&mut self.sequence, patch.sequence.saturating_add(1));
        gap(Channel::Map, due, patch.sequence, "patches")
    }

    /// The heartbeats missing before `beat`; `None` for the first heartbeat of a process, which may be of any age.
    pub fn beat(&mut self, beat: &Heartbeat) -> Option<SequenceGap> {
        if self.beats.len() >= PROCESSES_MAX && !self.beats.contains_key(&beat.incarnation) {
            self.beats.pop_first();
        }
        let last = self.beats.insert(beat.incarnation, beat.counter)?;
        let counted = format!("beats of {} {}", beat.role, beat.incarnation);
        gap(Channel::Heartbeat, last.checked_add(1)?, beat.counter, &counted)
    }

    /// Starts another run: its decisions and patches are counted from the beginning.
    pub fn begin(&mut self) {
        let beats = std::mem::take(&mut self.beats);
        *self = Self { beats, ..Self::default() };
    }
}

fn gap(topic: Channel, due: u64, next: u64, counted: &str) -> Option<SequenceGap> {
    let missing = next > due;
    missing.then(|| SequenceGap {
        topic: topic.name(),
        from: due,
        through: next - 1,
        counted: counted.into(),
    })
}
