//! Replays a recording: every decision with the observed map it had to be decided on.

use std::collections::BTreeMap;

use contract::{Brief, Decision, Leg, MonotonicNs, ObservedMap, State, Vetoed};
use follow::Replica;

use crate::RecordedMessage;
use crate::channel::ROBOT;

/// Most states that are kept while their map is incomplete.
const STATES_KEPT: usize = 4096;

/// Rebuilds the observed map from brief, states, patches and pages in the order of the recording.
#[derive(Clone, Debug)]
pub struct Playback {
    brief: Option<Brief>,
    map: Replica,
    states: BTreeMap<Decision, State>,
    /// The decision returned last, with its vetoes.
    last_due: Option<(Decision, Vetoed)>,
}

/// A decision that a planner had to take.
#[derive(Clone, Copy, Debug)]
pub struct PendingDecision<'a> {
    /// Brief of the run.
    pub brief: &'a Brief,
    /// The leg that robot 0 flies, if it is a hopper.
    pub leg: Option<Leg>,
    /// Observed map at the time.
    pub map: &'a ObservedMap,
    /// State at the time, with the union of all vetoes recorded for it.
    pub state: State,
}

impl Default for Playback {
    fn default() -> Self {
        Self { brief: None, map: Replica::new(ROBOT), states: BTreeMap::new(), last_due: None }
    }
}

impl Playback {
    /// Takes the next message, logged at `logged`. Returns the decision that is now due with its map complete, once
    /// for each set of vetoes.
    pub fn on(&mut self, message: &RecordedMessage, logged: MonotonicNs) -> Option<PendingDecision<'_>> {
        match message {
            RecordedMessage::Brief(brief) => {
                if self.brief.as_ref().is_none_or(|known| known.run != brief.run) {
                    *self = Self { brief: Some(brief.clone()), ..Self::default() };
                    self.map.begin(brief);
                }
            }
            RecordedMessage::State(state) => self.state(*state),
            // Requests for missing pages are dropped: a recording cannot answer them.
            RecordedMessage::Patch(patch) => drop(self.map.patch(patch.clone(), logged)),
            RecordedMessage::Page(page) => drop(self.map.page(page, logged)),
            _ => return None,
        }
        self.pending()
    }

    /// Brief of the run being replayed; `None` before the first.
    #[must_use]
    pub fn brief(&self) -> Option<&Brief> {
        self.brief.as_ref()
    }

    fn state(&mut self, state: State) {
        let is_of = |brief: &Brief| brief.run == state.run && state.robot.0 < brief.robots.count();
        if !self.brief.as_ref().is_some_and(is_of) {
            return;
        }
        let known = self.states.get(&state.decision).map_or(Vetoed::NONE, |known| known.vetoed);
        let vetoed = state.vetoed.union(known);
        self.states.insert(state.decision, State { vetoed, ..state });
        if self.states.len() > STATES_KEPT {
            self.states.pop_first();
        }
    }

    fn pending(&mut self) -> Option<PendingDecision<'_>> {
        let (brief, map) = (self.brief.as_ref()?, self.map.map()?);
        let state = *self.states.get(&map.through?)?;
        let due = (state.decision, state.vetoed);
        if state.status.is_over() || self.last_due == Some(due) {
            return None;
        }
        self.last_due = Some(due);
        self.states = self.states.split_off(&state.decision);
        Some(PendingDecision { brief, leg: brief.leg_of(ROBOT, state.visits), map, state })
    }
}
