//! The map that belongs to each state.

use std::collections::BTreeMap;

use contract::{Brief, Cell, Digest, Ground};

use crate::expected::Expected;

/// What is seen now, and the map that belongs to each state so far.
#[derive(Debug)]
pub(super) struct SeenMaps {
    pub expected: Expected,
    /// The cells and treasures that the map of each state holds.
    pub contents: BTreeMap<Digest, (Vec<Option<Ground>>, Vec<Cell>)>,
    /// Fingerprint of the map that belongs to each state.
    pub prints: BTreeMap<Digest, u64>,
    /// Cells that some pose so far could see.
    pub visible: Vec<bool>,
}

impl SeenMaps {
    /// Nothing is seen.
    pub fn unseen(brief: &Brief) -> Self {
        Self {
            expected: Expected::unseen(brief),
            contents: BTreeMap::new(),
            prints: BTreeMap::new(),
            visible: vec![false; brief.grid.cells()],
        }
    }

    /// The map that belongs to the state of `digest` is what is seen now.
    pub fn mapped_at(&mut self, digest: Digest) {
        for (index, visible) in self.visible.iter_mut().enumerate() {
            *visible |= self.expected.is_seen(index);
        }
        let print = self.expected.fingerprint();
        let (cells, treasures) = (self.expected.cells().to_vec(), self.expected.treasures().to_vec());
        self.contents.insert(digest, (cells, treasures));
        self.prints.insert(digest, print);
    }

    /// The maps of states of another mission, or of another past, stay valid for stragglers.
    pub fn keep(&mut self, old: Self) {
        self.prints.extend(old.prints);
        self.contents.extend(old.contents);
    }
}
