//! What was published and did not reach the recorder, told by the numbers that messages carry.

use std::collections::BTreeMap;

use contract::{Decision, Heartbeat, Incarnation, MapPatch, State};

use crate::Topic;

/// Lives whose beats are counted at once.
const LIVES_MAX: usize = 256;

/// Messages that are missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gap {
    /// Where.
    pub topic: String,
    /// First number missing.
    pub from: u64,
    /// Last number missing.
    pub through: u64,
    /// What is numbered.
    pub counted: String,
}

impl Gap {
    /// How many are missing.
    #[must_use]
    pub fn missing(&self) -> u64 {
        (self.through - self.from).saturating_add(1)
    }
}

/// Watches the numbers of one run's states and patches, and of beats. Commands carry none: they are repeated until
/// answered, so one that is lost is no loss.
#[derive(Clone, Debug)]
pub struct Gaps {
    /// What is due next: the first decision of a run is 0, its first patch 1.
    decision: u64,
    sequence: u64,
    beats: BTreeMap<Incarnation, u64>,
}

impl Default for Gaps {
    fn default() -> Self {
        Self { decision: 0, sequence: 1, beats: BTreeMap::new() }
    }
}

impl Gaps {
    /// What is missing before a state; before the first one, what was before the recorder's time. A decision that
    /// was told before is a repetition, or a journal that has lost its tail.
    pub fn state(&mut self, state: &State) -> Option<Gap> {
        let Decision(decision) = state.decision;
        let due = std::mem::replace(&mut self.decision, decision.saturating_add(1));
        gap(Topic::State, due, decision, "decisions")
    }

    /// What is missing before a patch; before the first one, what was before the recorder's time.
    pub fn patch(&mut self, patch: &MapPatch) -> Option<Gap> {
        let due = std::mem::replace(&mut self.sequence, patch.sequence.saturating_add(1));
        gap(Topic::Map, due, patch.sequence, "patches")
    }

    /// What is missing before a beat; a life that is heard for the first time may be of any age.
    pub fn beat(&mut self, beat: &Heartbeat) -> Option<Gap> {
        if self.beats.len() >= LIVES_MAX && !self.beats.contains_key(&beat.incarnation) {
            self.beats.pop_first();
        }
        let last = self.beats.insert(beat.incarnation, beat.counter)?;
        let counted = format!("beats of {} {}", beat.role, beat.incarnation);
        gap(Topic::Heartbeat, last.checked_add(1)?, beat.counter, &counted)
    }

    /// Begins anew: another run.
    pub fn begin(&mut self) {
        let beats = std::mem::take(&mut self.beats);
        *self = Self { beats, ..Self::default() };
    }
}

fn gap(topic: Topic, due: u64, next: u64, counted: &str) -> Option<Gap> {
    let missing = next > due;
    missing.then(|| Gap { topic: topic.name(), from: due, through: next - 1, counted: counted.into() })
}
