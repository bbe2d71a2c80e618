//! Folds the map of a run from its recorded messages, and says when it has changed.

use contract::{Brief, MonotonicNs, ObservedMap};
use follow::Replica;
use recording::RecordedMessage;
use recording::channel::ROBOT;

use crate::seen_box::SeenBox;

/// The map of one run as it grows.
#[derive(Clone, Debug)]
pub(crate) struct MapFollower {
    replica: Replica,
    /// Fingerprint of the map at its last change.
    observation: Option<u64>,
    seen: SeenBox,
}

impl MapFollower {
    /// Nothing seen yet.
    pub fn new(brief: &Brief) -> Self {
        let mut replica = Replica::new(ROBOT);
        replica.begin(brief);
        Self { replica, observation: None, seen: SeenBox::default() }
    }

    /// Takes a message; whether the map is whole and has changed with it.
    pub fn on(&mut self, message: RecordedMessage, logged: MonotonicNs) -> bool {
        // Nobody answers requests for what is missing: the recorder's own are answered by pages that follow.
        match message {
            RecordedMessage::Patch(patch) => drop(self.replica.patch(patch, logged)),
            RecordedMessage::Page(page) => drop(self.replica.page(&page, logged)),
            _ => return false,
        }
        let Some(map) = self.replica.map() else { return false };
        if map.through.is_none() || map.seen_cells() == 0 || self.observation == Some(map.observation()) {
            return false;
        }
        self.seen.grow(map, self.observation);
        self.observation = Some(map.observation());
        true
    }

    /// The map with the box of its seen cells; `None` while it is not whole.
    pub fn map(&self) -> Option<(&ObservedMap, &SeenBox)> {
        Some((self.replica.map()?, &self.seen))
    }
}
