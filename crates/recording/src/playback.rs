//! What was sensed, folded again: every decision with the map it was due on.

use std::collections::BTreeMap;

use contract::{Brief, Decision, MonotonicNs, ObservedMap, Replica, State, Vetoed};

use crate::Message;
use crate::topic::ROBOT;

/// States that are kept while their map is not there yet.
const STATES_KEPT: usize = 4096;

/// Folds brief, states, patches and pages in the order of the recording.
#[derive(Clone, Debug)]
pub struct Playback {
    brief: Option<Brief>,
    map: Replica,
    states: BTreeMap<Decision, State>,
    /// What was posed last.
    posed: Option<(Decision, Vetoed)>,
}

/// A decision as it was due.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    /// The brief of the leg.
    pub brief: Brief,
    /// What had been seen.
    pub map: &'a ObservedMap,
    /// Where the mission stood, and what the guard had vetoed.
    pub state: State,
}

impl Default for Playback {
    fn default() -> Self {
        Self { brief: None, map: Replica::new(ROBOT), states: BTreeMap::new(), posed: None }
    }
}

impl Playback {
    /// Takes the next message, logged at `logged`; the decision that can be taken now, once for each set of vetoes.
    pub fn on(&mut self, message: &Message, logged: MonotonicNs) -> Option<Posed<'_>> {
        match message {
            Message::Brief(brief) => {
                if self.brief.is_none_or(|known| known.run != brief.run) {
                    *self = Self { brief: Some(*brief), ..Self::default() };
                    self.map.begin(brief.run, brief.grid);
                }
            }
            Message::State(state) => self.state(*state),
            // Whether something would be asked for is of no interest: it is in the recording, or it is not.
            Message::Patch(patch) => drop(self.map.patch(patch.clone(), logged)),
            Message::Page(page) => drop(self.map.page(page, logged)),
            _ => return None,
        }
        self.pose()
    }

    /// The brief; `None` before the first.
    #[must_use]
    pub fn brief(&self) -> Option<&Brief> {
        self.brief.as_ref()
    }

    fn state(&mut self, state: State) {
        if self.brief.is_none_or(|brief| brief.run != state.run) || state.robot != ROBOT {
            return;
        }
        let known = self.states.get(&state.decision).map_or(Vetoed::NONE, |known| known.vetoed);
        let vetoed = state.vetoed.union(known);
        self.states.insert(state.decision, State { vetoed, ..state });
        if self.states.len() > STATES_KEPT {
            self.states.pop_first();
        }
    }

    fn pose(&mut self) -> Option<Posed<'_>> {
        let (brief, map) = (self.brief.as_ref()?, self.map.map()?);
        let state = *self.states.get(&map.through?)?;
        let due = (state.decision, state.vetoed);
        if state.status.is_over() || self.posed == Some(due) {
            return None;
        }
        self.posed = Some(due);
        self.states = self.states.split_off(&state.decision);
        Some(Posed { brief: brief.leg(state.visits), map, state })
    }
}
