//! The map on the ground, put together from patches of which some were lost or came late.

use std::collections::BTreeMap;

use contract::{Brief, MapPatch, ObservedMap, RobotId};

/// Gaps that are named at once; more are named as one.
const GAPS_MAX: usize = 64;

/// Patches that did not come, `first..=last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The first.
    pub first: u64,
    /// The last.
    pub last: u64,
}

/// The map as the ground has it. A cell says what the newest patch said of it that came, so it does not matter in which
/// order they come; and the fingerprint in the newest patch says whether the map is whole.
#[derive(Clone, Debug, Default)]
pub struct GroundMap {
    map: Option<ObservedMap>,
    /// The patch that each cell is from; 0 for none.
    from: Vec<u32>,
    /// Stretches of patches that came, by their first.
    came: BTreeMap<u64, u64>,
    /// The newest patch, without its cells.
    newest: Option<MapPatch>,
}

impl GroundMap {
    /// A mission begins; the same run again changes nothing.
    pub fn begin(&mut self, brief: &Brief) {
        if self.map.as_ref().is_some_and(|map| map.run == brief.run && map.grid == brief.grid) {
            return;
        }
        *self = Self {
            map: Some(ObservedMap::unseen(brief.run, RobotId(0), brief.grid)),
            from: vec![0; brief.grid.cells()],
            ..Self::default()
        };
    }

    /// What is known of the ground.
    #[must_use]
    pub fn map(&self) -> Option<&ObservedMap> {
        self.map.as_ref()
    }

    /// The newest patch, without its cells.
    #[must_use]
    pub fn newest(&self) -> Option<&MapPatch> {
        self.newest.as_ref()
    }

    /// Whether it is the map of the newest patch, cell by cell.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let (Some(map), Some(newest)) = (&self.map, &self.newest) else { return false };
        map.observation() == newest.after
    }

    /// Takes a patch; whether it is of the mission.
    pub fn patch(&mut self, patch: MapPatch) -> bool {
        let Some(map) = &mut self.map else { return false };
        if patch.run != map.run || patch.grid != map.grid {
            return false;
        }
        // Another life of the link, or of the journal's past: landings go on while the numbers of patches begin again.
        let is_another_stream = self.newest.as_ref().is_some_and(|newest| {
            let begins = patch.sequence == 1 && patch.before == 0 && self.came.contains_key(&1);
            let goes_on = patch.sequence < newest.sequence && patch.through > newest.through;
            begins && patch.published >= newest.published || goes_on
        });
        if is_another_stream {
            *map = ObservedMap::unseen(map.run, map.robot, map.grid);
            self.from.fill(0);
            self.came.clear();
            self.newest = None;
        }
        // A reminder has the number of the last patch, not its cells.
        let is_reminder = patch.cells.is_empty() && patch.before == patch.after;
        let sequence = patch.sequence;
        let number = u32::try_from(patch.sequence).unwrap_or(u32::MAX);
        for cell in &patch.cells {
            let at = cell.index as usize;
            if self.from[at] <= number {
                map.learn_visited(at, cell.ground, cell.visits);
                self.from[at] = number;
            }
        }
        if self.newest.as_ref().is_none_or(|newest| newest.sequence <= patch.sequence) {
            (map.through, map.digest, map.sequence) = (Some(patch.through), patch.digest, patch.sequence);
            (map.sensed, map.published) = (patch.sensed, patch.published);
            self.newest = Some(MapPatch { cells: Vec::new(), ..patch });
        }
        if let Some(newest) = &self.newest {
            let seen = newest.treasures.iter().copied().filter(|cell| map.ground(*cell).is_some());
            map.set_treasures(&seen.collect::<Vec<_>>());
        }
        map.mark();
        if sequence > 0 && !is_reminder {
            self.note(sequence);
        }
        true
    }

    /// Patches that did not come; none if the map is whole, whatever was lost. Their cells may have come since with
    /// later ones: the link knows. All are named if all came and yet the map is not whole.
    #[must_use]
    pub fn gaps(&self) -> Vec<Gap> {
        let Some(newest) = self.newest.as_ref().filter(|_| !self.is_whole()) else { return Vec::new() };
        let mut gaps = Vec::new();
        let mut next = 1;
        for (first, last) in &self.came {
            if next < *first {
                gaps.push(Gap { first: next, last: first - 1 });
            }
            next = last + 1;
        }
        if next <= newest.sequence {
            gaps.push(Gap { first: next, last: newest.sequence });
        }
        if gaps.is_empty() {
            gaps.push(Gap { first: 1, last: newest.sequence });
        }
        if let Some(last) = gaps.last().map(|gap| gap.last)
            && gaps.len() > GAPS_MAX
        {
            gaps.truncate(GAPS_MAX);
            gaps[GAPS_MAX - 1].last = last;
        }
        gaps
    }

    /// Notes that a patch came.
    fn note(&mut self, sequence: u64) {
        let before = self.came.range(..=sequence).next_back().map(|(first, last)| (*first, *last));
        let (mut first, mut last) = (sequence, sequence);
        if let Some((of, until)) = before {
            if until >= sequence {
                return;
            }
            if until + 1 == sequence {
                first = of;
            }
        }
        if let Some(until) = self.came.remove(&(sequence + 1)) {
            last = until;
        }
        self.came.insert(first, last);
    }
}
