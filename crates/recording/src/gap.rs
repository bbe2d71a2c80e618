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

/// Watches the numbers of states, patches and beats. Commands carry none: they are repeated until answered, so
/// one that is lost is no loss.
#[derive(Clone, Debug, Default)]
pub struct Gaps {
    decision: Option<Decision>,
    sequence: Option<u64>,
    beats: BTreeMap<Incarnation, u64>,
}

impl Gaps {
    /// What is missing before a state. A decision that was told before is a repetition, or a journal that has
    /// lost its tail.
    pub fn state(&mut self, state: &State) -> Option<Gap> {
        let last = self.decision.replace(state.decision)?;
        gap(Topic::State, last.0, state.decision.0, "decisions")
    }

    /// What is missing before a patch.
    pub fn patch(&mut self, patch: &MapPatch) -> Option<Gap> {
        let last = self.sequence.replace(patch.sequence)?;
        gap(Topic::Map, last, patch.sequence, "patches")
    }

    /// What is missing before a beat.
    pub fn beat(&mut self, beat: &Heartbeat) -> Option<Gap> {
        if self.beats.len() >= LIVES_MAX && !self.beats.contains_key(&beat.incarnation) {
            self.beats.pop_first();
        }
        let last = self.beats.insert(beat.incarnation, beat.counter)?;
        let counted = format!("beats of {} {}", beat.role, beat.incarnation);
        gap(Topic::Heartbeat, last, beat.counter, &counted)
    }

    /// Begins anew: another run.
    pub fn begin(&mut self) {
        (self.decision, self.sequence) = (None, None);
    }
}

fn gap(topic: Topic, last: u64, next: u64, counted: &str) -> Option<Gap> {
    let due = last.checked_add(1)?;
    let missing = next > due;
    missing.then(|| Gap { topic: topic.name(), from: due, through: next - 1, counted: counted.into() })
}
