//! The map on its way down.

use std::collections::BTreeSet;

use contract::{Brief, MapPage, MapPatch, MapRequest, MonotonicNs, ObservedMap, RobotId, SeenCell};
use follow::Replica;

/// Sends the observed map as patches of its own: what changed last first, the rest after. A cell that changes while it
/// waits is sent once, as it is then.
///
/// The patches go on one another as those of perception do, from the first one on an empty map, so whoever gets all of
/// them has the map by the same rule as any reader. What was lost on the way is sent again when it is asked for.
#[derive(Clone, Debug)]
pub struct MapSender {
    /// The map as the mission has it.
    replica: Replica,
    /// The map as the ground has it, if nothing was lost.
    sent: Option<ObservedMap>,
    /// The patch that each cell went down with last; 0 for none.
    sent_in: Vec<u32>,
    /// The fingerprint of the mission's map up to which changes are noted.
    noted: u64,
    /// Cells that changed with the last landing.
    fresh: BTreeSet<u32>,
    /// Cells that changed before.
    backlog: BTreeSet<u32>,
    /// Whether the ground is to be told again which patch was the last.
    reminds: bool,
}

impl MapSender {
    pub fn new() -> Self {
        Self {
            replica: Replica::new(RobotId(0)),
            sent: None,
            sent_in: Vec::new(),
            noted: 0,
            fresh: BTreeSet::new(),
            backlog: BTreeSet::new(),
            reminds: false,
        }
    }

    /// A mission begins, or its brief is told again.
    pub fn begin(&mut self, brief: &Brief) {
        self.replica.begin(brief);
        if self.sent.as_ref().is_none_or(|sent| sent.run != brief.run || sent.grid != brief.grid) {
            self.restart(ObservedMap::unseen(brief.run, RobotId(0), brief.grid));
        }
    }

    /// The journal has lost decisions: the map is sent again from its first patch.
    pub fn begin_anew(&mut self) {
        self.replica.begin_anew();
        if let Some(sent) = self.sent.take() {
            self.restart(ObservedMap::unseen(sent.run, sent.robot, sent.grid));
        }
    }

    fn restart(&mut self, unseen: ObservedMap) {
        self.sent_in = vec![0; unseen.grid.cells()];
        self.sent = Some(unseen);
        (self.noted, self.reminds) = (0, false);
        self.fresh.clear();
        self.backlog.clear();
    }

    /// Takes a patch; what is to be asked for.
    pub fn patch(&mut self, patch: MapPatch, now: MonotonicNs) -> Option<MapRequest> {
        let wanted = self.replica.patch(patch, now);
        self.note();
        wanted
    }

    /// Takes a page; what is to be asked for next.
    pub fn page(&mut self, page: &MapPage, now: MonotonicNs) -> Option<MapRequest> {
        let wanted = self.replica.page(page, now);
        self.note();
        wanted
    }

    /// What is to be asked for, if something is missing.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<MapRequest> {
        self.replica.ask(now)
    }

    /// Notes which cells have changed.
    fn note(&mut self) {
        let (Some(map), Some(sent)) = (self.replica.map(), &self.sent) else { return };
        if map.observation() == self.noted {
            return;
        }
        let differs = |index: &usize| {
            map.cells()[*index] != sent.cells()[*index] || map.visits(*index) != sent.visits(*index)
        };
        self.backlog.append(&mut self.fresh);
        self.fresh = match map.changed_since(self.noted) {
            Some(changed) => changed.iter().copied().filter(|index| differs(&(*index as usize))).collect(),
            // It may be that of another past, which lacks what was sent.
            None => (0..map.cells().len()).filter(differs).map(|index| index as u32).collect(),
        };
        self.fresh.retain(|index| map.cells()[*index as usize].is_some());
        self.noted = map.observation();
    }

    /// Whether there is something to send.
    pub fn has(&self) -> bool {
        let (Some(map), Some(sent)) = (self.replica.map(), &self.sent) else { return false };
        self.reminds
            || !self.fresh.is_empty()
            || !self.backlog.is_empty()
            || sent.treasures() != sendable(map, sent).as_slice()
    }

    /// Cells that wait.
    pub fn waiting(&self) -> usize {
        self.fresh.len() + self.backlog.len()
    }

    /// Cells that went down, each counted once.
    pub fn sent_cells(&self) -> usize {
        self.sent.as_ref().map_or(0, ObservedMap::seen_cells)
    }

    /// Tells the ground again which patch was the last, once nothing else is to be sent.
    pub fn remind(&mut self) {
        self.reminds = self.sent.as_ref().is_some_and(|sent| sent.sequence > 0);
    }

    /// Sends the cells again that the patches `first..=last` brought, or since then later ones.
    pub fn again(&mut self, first: u64, last: u64) {
        for (index, patch) in self.sent_in.iter().enumerate() {
            if *patch > 0 && (first..=last).contains(&u64::from(*patch)) {
                self.backlog.insert(index as u32);
            }
        }
        self.reminds = true;
    }

    /// The next patch, of at most so many cells.
    ///
    /// # Panics
    /// If there is nothing to send.
    pub fn next(&mut self, cells_max: usize) -> MapPatch {
        let map = self.replica.map().expect("a map that is whole");
        let sent = self.sent.as_mut().expect("a mission that has begun");
        let mut indices = BTreeSet::new();
        while indices.len() < cells_max
            && let Some(index) = self.fresh.pop_first().or_else(|| self.backlog.pop_first())
        {
            indices.insert(index);
        }
        self.reminds = false;
        let before = sent.observation();
        let sequence = if indices.is_empty() && sent.treasures() == sendable(map, sent).as_slice() {
            sent.sequence
        } else {
            sent.sequence + 1
        };
        let mut cells = Vec::with_capacity(indices.len());
        for index in indices {
            let at = index as usize;
            // A cell that is waiting is seen; after a loss of the journal it may be no longer.
            let Some(ground) = map.cells()[at] else { continue };
            cells.push(SeenCell { index, ground, visits: map.visits(at) });
            sent.learn_visited(at, ground, map.visits(at));
            self.sent_in[at] = sequence as u32;
        }
        let treasures = sendable(map, sent);
        sent.set_treasures(&treasures);
        sent.sequence = sequence;
        let waiting = self.fresh.len() + self.backlog.len();
        MapPatch {
            run: map.run,
            robot: map.robot,
            through: map.through.unwrap_or_default(),
            digest: map.digest,
            more: waiting.div_ceil(cells_max) as u32,
            sequence,
            before,
            after: sent.observation(),
            sensed: map.sensed,
            published: map.published,
            grid: map.grid,
            seen_cells: sent.seen_cells() as u32,
            treasures,
            cells,
        }
    }
}

/// The treasures whose cells have been sent.
fn sendable(map: &ObservedMap, sent: &ObservedMap) -> Vec<contract::Cell> {
    map.treasures().iter().copied().filter(|cell| sent.ground(*cell).is_some()).collect()
}
