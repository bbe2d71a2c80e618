//! What has been seen so far.

use std::collections::VecDeque;
use std::num::NonZeroU8;

use xxhash_rust::xxh3::xxh3_64;

use crate::limits::{CHANGES_KEPT, MARKS_KEPT};
use crate::{
    Cell, Decision, Digest, DriveSpeed, Grid, Ground, MapPatch, MonotonicNs, Refusal, RobotId, RunId,
    SeenCell, Soil, State,
};

/// The observed map: every cell either seen, or unknown.
///
/// It keeps count of itself as it grows: how much is seen, a fingerprint of all that is known, and which
/// cells changed of late. None of that is computed over the whole map again, so a landing costs what it
/// reveals.
#[derive(Clone, Debug)]
pub struct ObservedMap {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// The robot whose sensor built it.
    pub robot: RobotId,
    /// The last decision whose pose is folded in; `None` while nothing is, or while part of a landing is
    /// missing.
    pub through: Option<Decision>,
    /// [`crate::State::digest`] of the state whose pose was folded in last.
    pub digest: Digest,
    /// Patches of the run's stream that are folded in. The stream is a function of the poses alone, so
    /// this number means the same in every process and in every life of perception.
    pub sequence: u64,
    /// When the pose of `through` was folded in.
    pub sensed: MonotonicNs,
    /// When it was published.
    pub published: MonotonicNs,
    /// Lattice of the mission; every cell of the message lies on it.
    pub grid: Grid,
    cells: Vec<Option<Ground>>,
    /// How often rovers have entered each cell; empty until one has.
    visits: Vec<u16>,
    seen: usize,
    sand: usize,
    observation: u64,
    treasures: Vec<Cell>,
    changes: Changes,
}

/// Which cells changed of late.
#[derive(Clone, Debug, Default)]
struct Changes {
    /// Indices in the order of their changes.
    log: Vec<u32>,
    /// Changes before the first of `log`.
    forgotten: u64,
    /// Fingerprints the map has had, with the number of changes until then.
    marks: VecDeque<(u64, u64)>,
}

impl ObservedMap {
    /// A map of `grid` on which nothing has been seen.
    #[must_use]
    pub fn unseen(run: RunId, robot: RobotId, grid: Grid) -> Self {
        let mut map = Self {
            run,
            robot,
            through: None,
            digest: Digest::default(),
            sequence: 0,
            sensed: MonotonicNs(0),
            published: MonotonicNs(0),
            grid,
            cells: vec![None; grid.cells()],
            visits: Vec::new(),
            seen: 0,
            sand: 0,
            observation: 0,
            treasures: Vec::new(),
            changes: Changes::of_at_most(grid.cells()),
        };
        map.mark();
        map
    }

    /// A map of `grid` with `cells` in index order, `None` where unseen.
    ///
    /// # Panics
    /// If there are not as many as the grid has.
    #[must_use]
    pub fn of_cells(run: RunId, robot: RobotId, grid: Grid, cells: &[Option<Ground>]) -> Self {
        assert!(cells.len() == grid.cells(), "{} cells for a grid of {}", cells.len(), grid.cells());
        let mut map = Self::unseen(run, robot, grid);
        for (index, ground) in cells.iter().enumerate() {
            if let Some(ground) = ground {
                map.learn(index, *ground);
            }
        }
        map.mark();
        map
    }

    /// Whether everything seen up to `state` is in the map, and nothing else: the digest tells apart states of the same
    /// decision on different pasts.
    #[must_use]
    #[inline]
    pub fn is_of(&self, state: &State) -> bool {
        self.run == state.run && self.through == Some(state.decision) && self.digest == state.digest
    }

    /// Cells in index order, `None` where unseen.
    #[must_use]
    pub fn cells(&self) -> &[Option<Ground>] {
        &self.cells
    }

    /// What is known of `cell`; `None` where unseen or outside.
    #[must_use]
    pub fn ground(&self, cell: Cell) -> Option<&Ground> {
        self.cells[self.grid.index(cell)?].as_ref()
    }

    /// How often rovers have entered the cell at `index`, as far as it is counted: see [`crate::SeenCell::visits`].
    #[must_use]
    pub fn visits(&self, index: usize) -> u16 {
        self.visits.get(index).copied().unwrap_or(0)
    }

    /// Cells with treasures that have been seen and not yet collected, in index order.
    #[must_use]
    pub fn treasures(&self) -> &[Cell] {
        &self.treasures
    }

    /// Writes down which treasures have been seen and not yet collected, in index order.
    pub fn set_treasures(&mut self, treasures: &[Cell]) {
        if self.treasures != treasures {
            let step = Self::treasures_step(&self.treasures, treasures);
            self.observation = self.observation.wrapping_add(step);
            self.treasures.clear();
            self.treasures.extend_from_slice(treasures);
        }
    }

    /// By how much the fingerprint grows when the treasures change.
    #[must_use]
    pub fn treasures_step(before: &[Cell], after: &[Cell]) -> u64 {
        let sum = |cells: &[Cell]| cells.iter().fold(0_u64, |sum, &cell| sum.wrapping_add(mark_of(cell)));
        sum(after).wrapping_sub(sum(before))
    }

    /// Number of seen cells.
    #[must_use]
    pub fn seen_cells(&self) -> usize {
        self.seen
    }

    /// Number of seen cells that are sand.
    #[must_use]
    pub fn sand_cells(&self) -> usize {
        self.sand
    }

    /// Share of the map seen, 0 to 1.
    #[must_use]
    pub fn coverage(&self) -> f64 {
        self.seen as f64 / self.cells.len() as f64
    }

    /// Fingerprint of what is known: equal for equal cells, whoever built the map, when, and in what order.
    ///
    /// It is the sum, modulo 2⁶⁴, of one XXH3-64 a seen cell and one a treasure, so that a landing changes it
    /// by what it reveals. It guards against what is lost or damaged on the way, not against forgery.
    #[must_use]
    pub fn observation(&self) -> u64 {
        self.observation
    }

    /// Writes down what is known of a cell; says whether that is news.
    ///
    /// # Panics
    /// If `index` is not below the number of cells.
    pub fn learn(&mut self, index: usize, ground: Ground) -> bool {
        self.learn_visited(index, ground, self.visits(index))
    }

    /// As [`ObservedMap::learn`], with how often rovers have entered the cell.
    ///
    /// # Panics
    /// If `index` is not below the number of cells.
    pub fn learn_visited(&mut self, index: usize, ground: Ground, visits: u16) -> bool {
        if self.cells[index] == Some(ground) && visits == self.visits(index) {
            return false;
        }
        self.observation = self.observation.wrapping_add(self.step(index, &ground, visits));
        self.write(index, ground, visits);
        true
    }

    /// Folds a patch in that goes on from this map, if its cells make what it says they make.
    ///
    /// # Errors
    /// If the fingerprint is not that of its cells, or a treasure lies where nothing is seen. Nothing changes then.
    ///
    /// # Panics
    /// If a cell is outside of the lattice, which no patch from the wire has.
    pub fn apply(&mut self, patch: &MapPatch) -> Result<(), Refusal> {
        let treasures = Self::treasures_step(self.treasures(), &patch.treasures);
        let step = patch.cells.iter().fold(treasures, |sum, cell| {
            let index = cell.index as usize;
            sum.wrapping_add(self.step(index, &cell.ground, cell.visits))
        });
        let after = self.observation.wrapping_add(step);
        if after != patch.after {
            let need = format!("{after:016x}, which its cells make");
            return Err(Refusal::malformed("map.after", &need, format!("{:016x}", patch.after)));
        }
        let is_seen = |cell: &&Cell| {
            let index = self.grid.index(**cell).expect("a treasure lies on the lattice") as u32;
            self.ground(**cell).is_some()
                || patch.cells.binary_search_by_key(&index, |cell| cell.index).is_ok()
        };
        if let Some(cell) = patch.treasures.iter().find(|cell| !is_seen(cell)) {
            return Err(Refusal::malformed("map.treasures", "seen cells", cell));
        }
        self.learn_checked(&patch.cells, &patch.treasures, step);
        self.sequence = patch.sequence;
        (self.through, self.digest) = ((patch.more == 0).then_some(patch.through), patch.digest);
        (self.sensed, self.published) = (patch.sensed, patch.published);
        self.mark();
        Ok(())
    }

    /// Writes down cells and treasures that were checked to make the fingerprint grow by `step`: it is not computed
    /// again. No cell may come twice.
    fn learn_checked(&mut self, cells: &[SeenCell], treasures: &[Cell], step: u64) {
        for &SeenCell { index, ground, visits } in cells {
            self.write(index as usize, ground, visits);
        }
        if self.treasures != treasures {
            self.treasures.clear();
            self.treasures.extend_from_slice(treasures);
        }
        self.observation = self.observation.wrapping_add(step);
    }

    /// Writes a cell down, without its fingerprint.
    fn write(&mut self, index: usize, ground: Ground, visits: u16) {
        if visits != self.visits(index) {
            self.visits.resize(self.cells.len(), 0);
            self.visits[index] = visits;
        }
        match self.cells[index] {
            Some(before) => self.sand -= usize::from(before.soil == Soil::Sand),
            None => self.seen += 1,
        }
        self.sand += usize::from(ground.soil == Soil::Sand);
        self.cells[index] = Some(ground);
        self.changes.push(index as u32);
    }

    /// By how much the fingerprint grows when the cell at `index` becomes `ground`, entered `visits` times.
    #[must_use]
    pub fn step(&self, index: usize, ground: &Ground, visits: u16) -> u64 {
        let before = self.cells[index].as_ref();
        let before = before.map_or(0, |before| fingerprint(index, before, self.visits(index)));
        fingerprint(index, ground, visits).wrapping_sub(before)
    }

    /// Remembers the present state as one from which changes can be told: once a landing is folded in.
    pub fn mark(&mut self) {
        self.changes.mark(self.observation);
    }

    /// The cells that changed since the map had the fingerprint `observation`, in the order of their changes,
    /// possibly repeated; `None` if it never had it, or too long ago: then anything may have changed.
    ///
    /// Treasures are too few to need a list of changes: compare [`ObservedMap::treasures`].
    ///
    /// This goes by content, not by object: two maps with one fingerprint hold the same cells, so a planner
    /// may ask any map on the same lattice, and gets a list that holds every difference, or `None`.
    #[must_use]
    pub fn changed_since(&self, observation: u64) -> Option<&[u32]> {
        self.changes.since(observation)
    }
}

impl PartialEq for ObservedMap {
    /// Whether both tell the same, however they came to know it.
    fn eq(&self, other: &Self) -> bool {
        (self.run, self.robot, self.through, self.sequence, self.sensed, self.published, self.grid)
            == (
                other.run,
                other.robot,
                other.through,
                other.sequence,
                other.sensed,
                other.published,
                other.grid,
            )
            && self.treasures == other.treasures
            && self.cells == other.cells
            && (0..self.cells.len()).all(|index| self.visits(index) == other.visits(index))
    }
}

impl Changes {
    /// None yet, with room for one of each cell, up to as many as are kept.
    fn of_at_most(cells: usize) -> Self {
        Self { log: Vec::with_capacity(cells.min(2 * CHANGES_KEPT)), ..Self::default() }
    }

    fn push(&mut self, index: u32) {
        if self.log.len() >= 2 * CHANGES_KEPT {
            self.log.drain(..CHANGES_KEPT);
            self.forgotten += CHANGES_KEPT as u64;
        }
        self.log.push(index);
    }

    /// A state that is marked already takes no place of another: a hopper may stand still for hours.
    fn mark(&mut self, observation: u64) {
        if self.marks.back().is_some_and(|(last, _)| *last == observation) {
            return;
        }
        let made = self.forgotten + self.log.len() as u64;
        self.marks.push_back((observation, made));
        let forgotten = self.forgotten;
        while self.marks.len() > MARKS_KEPT || self.marks.front().is_some_and(|(_, made)| *made < forgotten) {
            self.marks.pop_front();
        }
    }

    fn since(&self, observation: u64) -> Option<&[u32]> {
        let (_, made) = self.marks.iter().rev().find(|(marked, _)| *marked == observation)?;
        Some(&self.log[made.checked_sub(self.forgotten)? as usize..])
    }
}

/// XXH3-64 of one treasure.
fn mark_of(cell: Cell) -> u64 {
    let mut bytes = [0; 8];
    bytes[..4].copy_from_slice(&cell.x.to_le_bytes());
    bytes[4..].copy_from_slice(&cell.y.to_le_bytes());
    xxh3_64(&bytes)
}

/// XXH3-64 of one seen cell; visits and reports count only where there were any.
fn fingerprint(index: usize, ground: &Ground, visits: u16) -> u64 {
    let mut bytes = [0; 33];
    bytes[..4].copy_from_slice(&(index as u32).to_le_bytes());
    bytes[4..12].copy_from_slice(&ground.height_m.to_bits().to_le_bytes());
    bytes[12..20].copy_from_slice(&ground.gradient[0].to_bits().to_le_bytes());
    bytes[20..28].copy_from_slice(&ground.gradient[1].to_bits().to_le_bytes());
    // Speed and reading stand above the bit of the soil, and only where there is one: so the others' fingerprints are as ever.
    let number = |speed: Option<DriveSpeed>| speed.map_or(0, |speed| speed as u8 + 1);
    bytes[28] = u8::from(ground.soil == Soil::Sand) | number(ground.speed) << 1 | number(ground.reading) << 4;
    bytes[29] = u8::from(ground.passable);
    bytes[30..32].copy_from_slice(&visits.to_le_bytes());
    bytes[32] = ground.reported.map_or(0, NonZeroU8::get);
    match (bytes[32], visits) {
        (0, 0) => xxh3_64(&bytes[..30]),
        (0, _) => xxh3_64(&bytes[..32]),
        _ => xxh3_64(&bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> ObservedMap {
        ObservedMap::unseen(RunId(1), RobotId(0), Grid::new(300, 300, 1.0, 1).unwrap())
    }

    fn ground(height_m: f64, soil: Soil) -> Ground {
        Ground { height_m, soil, ..Ground::FLAT }
    }

    #[test]
    fn the_counts_and_the_fingerprint_are_those_of_the_cells_however_they_came() {
        let news = [(7, 1.0, Soil::Hard), (3, 2.0, Soil::Sand), (7, 1.5, Soil::Sand), (9, 0.0, Soil::Hard)];
        let mut map = map();
        let empty = map.observation();
        for (index, height_m, soil) in news {
            assert!(map.learn(index, ground(height_m, soil)));
            assert!(!map.learn(index, ground(height_m, soil)), "no news");
        }
        assert_eq!((map.seen_cells(), map.sand_cells()), (3, 2));
        assert_ne!(map.observation(), empty);
        let rebuilt = ObservedMap::of_cells(map.run, map.robot, map.grid, map.cells());
        assert_eq!(rebuilt.observation(), map.observation());
        assert_eq!((rebuilt.seen_cells(), rebuilt.sand_cells()), (3, 2));
        assert_eq!(rebuilt, map);
    }

    #[test]
    fn what_is_reported_changes_the_fingerprint_and_no_other_cell_has_it() {
        let observation = |reported, visits| {
            let mut map = map();
            map.learn_visited(7, Ground { reported: NonZeroU8::new(reported), ..Ground::FLAT }, visits);
            map.observation()
        };
        let mut all: Vec<u64> =
            [(0, 0), (0, 1), (1, 0), (1, 1), (255, 0)].map(|(r, v)| observation(r, v)).into();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 5);
    }

    #[test]
    fn changes_are_told_since_any_marked_state_and_nothing_is_told_of_others() {
        let mut map = map();
        let empty = map.observation();
        map.learn(5, ground(1.0, Soil::Hard));
        map.mark();
        let first = map.observation();
        map.learn(6, ground(1.0, Soil::Hard));
        map.learn(5, ground(2.0, Soil::Hard));
        map.mark();
        assert_eq!(map.changed_since(empty), Some(&[5, 6, 5][..]));
        assert_eq!(map.changed_since(first), Some(&[6, 5][..]));
        assert_eq!(map.changed_since(map.observation()), Some(&[][..]));
        assert_eq!(map.changed_since(12345), None);
    }

    #[test]
    fn standing_still_makes_no_change_forgotten() {
        let mut map = map();
        let empty = map.observation();
        map.learn(5, ground(1.0, Soil::Hard));
        for _ in 0..3 * MARKS_KEPT {
            map.mark();
        }
        assert_eq!(map.changed_since(empty), Some(&[5][..]));
        assert_eq!(map.changed_since(map.observation()), Some(&[][..]));
    }

    #[test]
    fn the_memory_of_changes_is_bounded_and_never_tells_less_than_changed() {
        let mut map = map();
        let empty = map.observation();
        let mut marked = Vec::new();
        for round in 0..4 {
            for index in 0..map.grid.cells() {
                map.learn(index, ground(f64::from(round) + 1.0, Soil::Hard));
                if index % 999 == 0 {
                    map.mark();
                    marked.push((map.observation(), map.cells().to_vec()));
                }
            }
        }
        assert_eq!(map.changed_since(empty), None, "too long ago");
        let mut told = 0;
        for (observation, before) in marked {
            let Some(changed) = map.changed_since(observation) else { continue };
            told += 1;
            assert!(changed.len() <= 2 * CHANGES_KEPT);
            let differ = |index: &usize| before[*index] != map.cells()[*index];
            let mut listed = vec![false; before.len()];
            changed.iter().for_each(|&index| listed[index as usize] = true);
            assert!((0..before.len()).filter(differ).all(|index| listed[index]));
        }
        assert!(told > 10);
    }
}
