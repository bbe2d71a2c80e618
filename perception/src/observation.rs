//! What is known of seen cells, among them their gradients.
//!
//! A landing costs what its disc holds, never what the map holds.

use std::num::NonZeroU8;

use contract::limits::MAP_PATCH_CELLS;
use contract::{
    Account, Brief, Cell, Decision, DriveSpeed, GradientSource, Ground, ObservedMap, Pose, Robot, RobotId,
};
use terrain::{Terrain, differences};

use crate::sensing::around;

/// The observed map under construction.
#[derive(Clone, Debug)]
pub struct Observation {
    map: ObservedMap,
    gradient: GradientSource,
    /// Most cells of a patch.
    patch_cells: usize,
    /// Cells that have been seen, this landing's among them: one bit each, so that the disc is looked up in
    /// the nearest memory whatever the size of the map.
    known: Bits,
    /// Seen cells that only a camera that errs has seen.
    doubtful: Bits,
    /// What the next landing's sensor reports of cells around it.
    reports: Vec<(usize, NonZeroU8)>,
    /// Cells that the last landing changed, in index order.
    landing: Vec<u32>,
    /// Fingerprint of the map before the last landing, and after each of its patches.
    links: Vec<u64>,
    /// Seen cells after each patch of the last landing.
    seen: Vec<u32>,
    /// Treasures before the last landing.
    treasures: Vec<Cell>,
    /// Whether the speed that a camera that errs has read decides if ground is passable: only in the mission of a rover and its
    /// helicopters. Among robots of other kinds, passable ground is what hoppers can stand on.
    passable_by_speed: bool,
}

/// A set of indices.
#[derive(Clone, Debug, Default)]
struct Bits(Vec<u64>);

impl Bits {
    fn has(&self, index: usize) -> bool {
        self.0[index / 64] >> (index % 64) & 1 == 1
    }

    fn add(&mut self, index: usize) {
        self.0[index / 64] |= 1 << (index % 64);
    }

    fn remove(&mut self, index: usize) {
        self.0[index / 64] &= !(1 << (index % 64));
    }
}

impl Observation {
    /// A map on which nothing has been seen.
    #[must_use]
    pub fn unseen(brief: &Brief, robot: RobotId) -> Self {
        let gradient = |robot: &Robot| Some(robot.as_hopper()?.1.gradient);
        Self {
            map: ObservedMap::unseen(brief.run, robot, brief.grid),
            gradient: brief.robots.iter().find_map(gradient).unwrap_or_default(),
            patch_cells: MAP_PATCH_CELLS,
            known: Bits(vec![0; brief.grid.cells().div_ceil(64)]),
            doubtful: Bits(vec![0; brief.grid.cells().div_ceil(64)]),
            reports: Vec::new(),
            landing: Vec::new(),
            links: Vec::new(),
            seen: Vec::new(),
            treasures: Vec::new(),
            passable_by_speed: brief.account != Account::ActionsWithoutWaits,
        }
    }

    /// This observation, its landings cut to patches of at most `cells` cells.
    pub(crate) fn cut_to(mut self, cells: usize) -> Self {
        self.patch_cells = cells;
        self
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> &ObservedMap {
        &self.map
    }

    pub(crate) fn into_map(self) -> ObservedMap {
        self.map
    }

    pub(crate) fn map_mut(&mut self) -> &mut ObservedMap {
        &mut self.map
    }

    /// Treasures before the last landing: the last of its patches brings those after it.
    pub(crate) fn treasures_before(&self) -> &[Cell] {
        &self.treasures
    }

    /// What the last landing changed, cut to patches: fingerprints before and after, seen cells after, and
    /// the indices of the changed cells. A landing that changed nothing is one empty patch.
    pub(crate) fn parts(&self) -> impl ExactSizeIterator<Item = ([u64; 2], u32, &[u32])> {
        (1..self.links.len()).map(|part| {
            let cells = self.landing.chunks(self.patch_cells).nth(part - 1).unwrap_or(&[]);
            ([self.links[part - 1], self.links[part]], self.seen[part - 1], cells)
        })
    }

    /// Folds in what the hopper that is robot 0 sees from `pose` at `decision`. Of `terrain` only the cells of the
    /// sensing disc are read, and of its treasures only those there, and heights that were read before.
    ///
    /// # Panics
    /// If the terrain is not on the brief's grid.
    pub fn fold(&mut self, brief: &Brief, terrain: &Terrain, pose: Pose, decision: Decision) {
        let seen = around(brief.grid, brief.robots[0].sensor, pose);
        self.sense(terrain, seen, &[], Some(pose.cell), decision);
    }

    /// Folds in what robots see: `seen` along their ways and around them, and the cells that rovers have `entered`, each another,
    /// which counts as a visit. A hopper, if one has landed, is on `landed`. If nothing is new, nothing changes but the decision.
    ///
    /// # Panics
    /// If the terrain is not on the brief's grid, or a cell lies outside.
    pub fn sense(
        &mut self,
        terrain: &Terrain,
        seen: impl IntoIterator<Item = usize>,
        entered: &[Cell],
        landed: Option<Cell>,
        decision: Decision,
    ) {
        let grid = self.map.grid;
        assert!(terrain.grid == grid, "terrain and brief disagree on the grid");
        self.landing.clear();
        let news = seen.into_iter().filter(|&index| !self.known.has(index) || self.doubtful.has(index));
        self.landing.extend(news.map(|index| index as u32));
        let entered: Vec<usize> = entered.iter().filter_map(|cell| grid.index(*cell)).collect();
        self.landing.extend(entered.iter().map(|&index| index as u32));
        self.landing.sort_unstable();
        self.landing.dedup();
        self.landing.iter().for_each(|&index| self.doubtful.remove(index as usize));
        self.reveal(terrain, landed, &entered, decision);
    }

    /// Takes note of what the sensor of the next landing reports of cells that it sees, by their indices. A cell keeps the highest.
    pub fn note_reports(&mut self, reports: impl IntoIterator<Item = (usize, NonZeroU8)>) {
        self.reports.extend(reports);
    }

    /// Folds in the cells of the landing, which were unknown or doubtful, or are visited; the hopper, if one has landed, is on
    /// `landed`.
    fn reveal(&mut self, terrain: &Terrain, landed: Option<Cell>, entered: &[usize], decision: Decision) {
        let counted = |index, visits: u16| {
            if entered.contains(&index) { visits.saturating_add(1) } else { visits }
        };
        let grid = self.map.grid;
        self.links.clear();
        self.seen.clear();
        self.treasures = self.map.treasures().to_vec();
        let treasures = self.treasures_after(terrain, landed);
        self.landing.iter().for_each(|&index| self.known.add(index as usize));
        self.add_reported();
        match self.gradient {
            GradientSource::Measured => {
                self.learn(terrain, |ground, index, visits| (ground, counted(index, visits)));
            }
            GradientSource::SeenDifferences => {
                self.add_rim();
                let known = std::mem::take(&mut self.known);
                let height = |cell: Cell| {
                    let index = grid.index(cell).filter(|&index| known.has(index))?;
                    Some(terrain.cells[index].height_m)
                };
                self.learn(terrain, |ground, index, visits| {
                    let gradient = differences(grid.cell(index), grid.cell_size_m, height);
                    (Ground { gradient, ..ground }, counted(index, visits))
                });
                self.known = known;
            }
        }
        self.map.set_treasures(&treasures);
        self.close_landing(decision);
    }

    /// Folds in that a camera that errs has seen these cells. Of a cell that has been seen it says nothing new; what it has read,
    /// a sensor that does not err corrects.
    ///
    /// # Panics
    /// If the terrain is not on the brief's grid, or a cell lies outside.
    pub fn read(&mut self, terrain: &Terrain, seen: impl IntoIterator<Item = usize>, decision: Decision) {
        assert!(terrain.grid == self.map.grid, "terrain and brief disagree on the grid");
        self.landing.clear();
        let news = seen.into_iter().filter(|&index| !self.known.has(index));
        self.landing.extend(news.map(|index| index as u32));
        self.landing.sort_unstable();
        self.landing.dedup();
        self.landing.iter().for_each(|&index| self.doubtful.add(index as usize));
        self.reveal(terrain, None, &[], decision);
    }

    fn close_landing(&mut self, decision: Decision) {
        *self.links.last_mut().expect("a landing has an end") = self.map.observation();
        self.map.through = Some(decision);
        self.map.sequence += self.links.len() as u64 - 1;
        self.map.mark();
    }

    /// A treasure is known from the moment its cell is revealed, once, until the hopper lands on it.
    fn treasures_after(&self, terrain: &Terrain, landed: Option<Cell>) -> Vec<Cell> {
        let grid = self.map.grid;
        let is_known = |cell: &&Cell| {
            let revealed = || {
                let mut new = self.landing.iter().filter(|&&index| !self.known.has(index as usize));
                new.any(|&index| grid.index(**cell) == Some(index as usize))
            };
            Some(**cell) != landed && (self.treasures.contains(cell) || revealed())
        };
        // Those of the terrain are in index order.
        terrain.treasures.iter().filter(is_known).copied().collect()
    }

    /// Adds the cells of which more is reported than the map has to the landing.
    fn add_reported(&mut self) {
        if self.reports.is_empty() {
            return;
        }
        // Of each cell the highest report.
        self.reports.sort_unstable_by(|a, b| (a.0, b.1).cmp(&(b.0, a.1)));
        self.reports.dedup_by_key(|(index, _)| *index);
        let cells = self.map.cells();
        let before = |index: usize| cells[index].as_ref().and_then(|ground| ground.reported);
        let is_more = |(index, report): &&(usize, NonZeroU8)| before(*index) < Some(*report);
        self.landing.extend(self.reports.iter().filter(is_more).map(|(index, _)| *index as u32));
        self.landing.sort_unstable();
        self.landing.dedup();
    }

    /// Adds the known neighbours of revealed cells to the landing: their gradients may change.
    fn add_rim(&mut self) {
        let grid = self.map.grid;
        for revealed in 0..self.landing.len() {
            let cell = grid.cell(self.landing[revealed] as usize);
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let neighbour = grid.index(Cell::new(cell.x + dx, cell.y + dy));
                let known = neighbour.filter(|&neighbour| self.known.has(neighbour));
                self.landing.extend(known.map(|known| known as u32));
            }
        }
        self.landing.sort_unstable();
        self.landing.dedup();
    }

    /// Writes the landing's cells down as `told` makes them of what sensors show, with their visits if these change, and takes note
    /// of the chain of patches. What turns out to be no news is left out of the landing.
    fn learn(&mut self, terrain: &Terrain, told: impl Fn(Ground, usize, u16) -> (Ground, u16)) {
        let Self { map, patch_cells, doubtful, reports, landing, links, seen, passable_by_speed, .. } = self;
        links.push(map.observation());
        let mut changed = 0;
        landing.retain(|&index| {
            let is_doubtful = || doubtful.has(index as usize);
            let shown = shown(&terrain.cells[index as usize], *passable_by_speed, is_doubtful);
            let report = reports.binary_search_by_key(&(index as usize), |(index, _)| *index);
            let before = map.cells()[index as usize].as_ref().and_then(|ground| ground.reported);
            let reported = before.max(report.ok().map(|place| reports[place].1));
            let shown = Ground { reported, ..shown };
            let (ground, visits) = told(shown, index as usize, map.visits(index as usize));
            let news = map.learn_visited(index as usize, ground, visits);
            changed += usize::from(news);
            if news && changed.is_multiple_of(*patch_cells) {
                links.push(map.observation());
                seen.push(map.seen_cells() as u32);
            }
            news
        });
        reports.clear();
        if changed == 0 || !changed.is_multiple_of(*patch_cells) {
            links.push(map.observation());
            seen.push(map.seen_cells() as u32);
        }
    }
}

/// What sensors show of a true cell: where no camera errs, all of it; otherwise either the speed or its reading, by which the
/// cell then counts as passable if that goes by the speed.
fn shown(truth: &Ground, passable_by_speed: bool, is_doubtful: impl Fn() -> bool) -> Ground {
    match truth.reading {
        None => *truth,
        Some(reading) if is_doubtful() => {
            let passable = if passable_by_speed { reading != DriveSpeed::Zero } else { truth.passable };
            Ground { speed: None, passable, ..*truth }
        }
        Some(_) => Ground { reading: None, ..*truth },
    }
}
