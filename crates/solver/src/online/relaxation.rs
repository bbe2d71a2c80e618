//! Active-set Gauss–Seidel from ring to ring: afterstate values converge again where something changed.
//!
//! A block is *marked* if its nodes' residuals |TW − W| are not known to be at most the tolerance. A visit measures
//! them. Lanes above the tolerance take a step, and the blocks whose residuals depend on them are marked: this one, and
//! those of the lanes' neighbours. Marks are stored 64 to a word, a block at the same bit on every ring, so that the
//! visits to a row mark its neighbours at once; the words are in the order of visits, so that a pass runs through them.
//! If no lane steps, the block has converged: its residuals are known, and remain so until a neighbour or the ground
//! changes, which marks it again. When nothing is marked, every node's residual is at most the tolerance, measured after
//! the last change of any of its inputs: a proof as strong as a full sweep, whatever was visited.
//!
//! Visits go outwards, the way changes at the goal travel, so a change reaches all that depends on it in one pass. Only
//! slips back towards the goal remain, one ring per pass. So that far levels are not visited again for every correction
//! of near ones, a pass goes no further than [`WINDOW`] levels beyond the first marked one.
//!
//! On some steep worlds these steps cycle. After [`FAST_SWEEPS_MAX`] sweeps without convergence they are *safeguarded*
//! ([`super::kernel::backup`]), which converges, though slowly. After [`SWEEPS_MAX`] the relaxation *gives up*, and
//! visits nothing until it is started again.

use std::ops::Range;

use super::blocks::Blocks;
use super::kernel::Lanes;
use super::layout::Layout;
use super::rings::{BLOCKS, Rings, Row, Slot};
use crate::GridWorld;
use crate::simd::DOUBLE_LANES as LANES;

/// Most levels of a pass.
const WINDOW: usize = 40;

/// Sweeps without convergence after which steps are safeguarded.
const FAST_SWEEPS_MAX: u64 = 64;

/// Sweeps without convergence after which the relaxation gives up.
const SWEEPS_MAX: u64 = 1024;

/// One or several fields on one world, and their marks: a block is marked if it is in any field.
#[derive(Clone, Debug)]
pub(super) struct Relaxation<const FIELDS: usize> {
    pub afterstates: [Vec<f64>; FIELDS],
    marks: Vec<u64>,
    /// Range of rows outside of which nothing is marked.
    marked: (usize, usize),
    /// Blocks that converged only at a coarse tolerance, of at most `coarse_tolerance`.
    coarse: Vec<u64>,
    coarse_rows: (usize, usize),
    coarse_tolerance: f64,
    /// Visits since it last converged.
    unconverged_visits: u64,
}

/// Where a relaxation ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Residual to converge to.
    pub tolerance: f64,
    /// The finest residual that will ever be asked for.
    pub finest: f64,
    /// First level that is not updated.
    pub frozen_from: usize,
    /// Most blocks to visit; the last row may exceed it.
    pub visits_max: u64,
}

/// The empty range of rows.
const NONE: (usize, usize) = (usize::MAX, 0);

fn with(rows: (usize, usize), row: usize) -> (usize, usize) {
    (rows.0.min(row), rows.1.max(row + 1))
}

impl<const FIELDS: usize> Default for Relaxation<FIELDS> {
    fn default() -> Self {
        Self {
            afterstates: std::array::from_fn(|_| Vec::new()),
            marks: Vec::new(),
            marked: NONE,
            coarse: Vec::new(),
            coarse_rows: NONE,
            coarse_tolerance: 0.0,
            unconverged_visits: 0,
        }
    }
}

impl<const FIELDS: usize> Relaxation<FIELDS> {
    pub fn clear(&mut self, rings: &Rings) {
        for marks in [&mut self.marks, &mut self.coarse] {
            marks.clear();
            marks.resize(rings.rows.len(), 0);
        }
        (self.marked, self.coarse_rows, self.coarse_tolerance) = (NONE, NONE, 0.0);
        self.unconverged_visits = 0;
    }

    /// Starts with the row-major `values` in every field, all blocks marked.
    pub fn begin(&mut self, layout: &Layout, world: &GridWorld, values: &[f64]) {
        for afterstates in &mut self.afterstates {
            layout.fill(world, values, afterstates);
        }
        self.clear(&layout.rings);
        for level in 0..layout.rings.levels {
            self.mark_level(&layout.rings, level);
        }
    }

    /// Copies the marks of `other`, and its first field into every field.
    pub fn copy_from<const OTHERS: usize>(&mut self, other: &Relaxation<OTHERS>) {
        for afterstates in &mut self.afterstates {
            afterstates.clone_from(&other.afterstates[0]);
        }
        self.marks.clone_from(&other.marks);
        self.marked = other.marked;
        self.coarse.clone_from(&other.coarse);
        (self.coarse_rows, self.coarse_tolerance) = (other.coarse_rows, other.coarse_tolerance);
        self.unconverged_visits = other.unconverged_visits;
    }

    /// Whether nothing is marked below `frozen_from`.
    pub fn is_converged(&self, rings: &Rings, frozen_from: usize) -> bool {
        self.marked.0 >= self.marked.1.min(rings.rows_of(0..frozen_from).end)
    }

    /// Whether it gave up: see the module.
    pub fn has_given_up(&self, rings: &Rings) -> bool {
        self.unconverged_visits > SWEEPS_MAX * rings.blocks
    }

    /// Marks a node's block and those of its neighbours, after a change of its value or its ground.
    pub fn mark_around(&mut self, layout: &Layout, slot: Slot) {
        let row = layout.rings.at(slot.ring).row(slot.block / BLOCKS);
        let at = |lane: usize| u64::from(slot.entry % LANES == lane) << (slot.block % BLOCKS);
        let moved = Moved { any: 1 << (slot.block % BLOCKS), first: at(0), last: at(LANES - 1) };
        let start = self.mark_readers(layout, row, &moved);
        self.marked = with(self.marked, start);
    }

    /// Marks all blocks of a level.
    pub fn mark_level(&mut self, rings: &Rings, level: usize) {
        for row in rings.rows_of(level..level + 1) {
            self.marks[row] = rings.rows[row].valid;
            self.marked = with(self.marked, row);
        }
    }

    /// The levels from `level` on that may have marks.
    pub fn marked_from(&self, rings: &Rings, level: usize) -> Range<usize> {
        let rows = self.marked.0.max(rings.rows_of(0..level).end)..self.marked.1;
        match rings.rows.get(rows) {
            Some([first, .., last]) => first.level as usize..last.level as usize + 1,
            Some([row]) => row.level as usize..row.level as usize + 1,
            _ => level..level,
        }
    }

    /// Removes the marks of all levels from `level` on.
    pub fn unmark_from(&mut self, rings: &Rings, level: usize) {
        let first = rings.rows_of(0..level).end;
        if first < self.marked.1 {
            self.marks[first.max(self.marked.0)..self.marked.1].fill(0);
            self.marked.1 = first;
        }
        if self.marked.0 >= self.marked.1 {
            self.marked = NONE;
        }
    }

    /// Marks the blocks before level `frozen_from` that converged only at a tolerance above `tolerance`.
    pub fn refine(&mut self, rings: &Rings, tolerance: f64, frozen_from: usize) {
        if self.coarse_tolerance <= tolerance {
            return;
        }
        for row in self.coarse_rows.0..self.coarse_rows.1.min(rings.rows_of(0..frozen_from).end) {
            self.marks[row] |= std::mem::take(&mut self.coarse[row]);
            self.marked = with(self.marked, row);
        }
        (self.coarse_rows, self.coarse_tolerance) = (NONE, 0.0);
    }

    /// Adds each field's rise to its values at a level's free nodes, without marking.
    pub fn raise_level(&mut self, layout: &Layout, level: usize, rises: [f64; FIELDS]) {
        let rings = &layout.rings;
        for sector in rings.sectors() {
            let Some(ring) = rings.ring(sector, level) else { continue };
            let entries = rings.at(ring).entries();
            for (afterstates, rise) in self.afterstates.iter_mut().zip(rises) {
                for (value, free) in afterstates[entries.clone()].iter_mut().zip(layout.free(entries.clone()))
                {
                    let raised = (*value + rise).clamp(-layout.magnitude, layout.magnitude);
                    *value = if free { raised } else { *value };
                }
                for ghost in rings.ghosts(ring) {
                    afterstates[ghost.to] = afterstates[ghost.from];
                }
            }
        }
    }

    /// The largest value of `of` over the fields' residuals TW − W in the marked blocks of `levels`, at
    /// least 0.
    pub fn worst(&self, layout: &Layout, levels: Range<usize>, of: impl Fn([f64; FIELDS]) -> f64) -> f64 {
        let mut worst = 0.0_f64;
        let rows = layout.rings.rows_of(levels);
        for row in rows.start.max(self.marked.0)..rows.end.min(self.marked.1) {
            let blocks = Blocks::of(layout, &layout.rings.rows[row]);
            let marks = self.marks[row] & layout.rings.rows[row].valid;
            for block in (0..BLOCKS).filter(|bit| marks & (1 << bit) != 0) {
                let residuals = self
                    .afterstates
                    .each_ref()
                    .map(|afterstates| blocks.measure::<false>(afterstates, block, 0.0).0);
                let of_lane = |lane: usize| of(residuals.map(|residual| residual[lane]));
                worst = (0..LANES).map(of_lane).fold(worst, f64::max);
            }
        }
        worst
    }

    /// Whether steps have to be safeguarded.
    pub fn needs_safeguard(&self, rings: &Rings) -> bool {
        self.unconverged_visits > FAST_SWEEPS_MAX * rings.blocks
    }

    /// Makes steps safeguarded at once.
    #[cfg(test)]
    pub fn exhaust_fast_steps(&mut self, rings: &Rings) {
        self.unconverged_visits = FAST_SWEEPS_MAX * rings.blocks + 1;
    }

    /// Relaxes until nothing is marked below `limits.frozen_from`, the visits run out, it gives up, or steps have to be
    /// safeguarded and these are not. Returns the visits.
    #[inline(always)]
    pub fn relax<const SAFEGUARDED: bool>(&mut self, layout: &Layout, limits: &Limits) -> u64 {
        let rings = &layout.rings;
        let end = rings.rows_of(0..limits.frozen_from).end;
        let mut visits = 0;
        loop {
            self.tighten(rings);
            if self.is_converged(rings, limits.frozen_from) {
                self.unconverged_visits = 0;
                return visits;
            }
            if visits >= limits.visits_max
                || self.has_given_up(rings)
                || self.needs_safeguard(rings) != SAFEGUARDED
            {
                return visits;
            }
            let visits_max = limits.visits_max - visits;
            let more = if limits.tolerance > limits.finest {
                self.pass::<SAFEGUARDED, true>(layout, limits, end, visits_max)
            } else {
                self.pass::<SAFEGUARDED, false>(layout, limits, end, visits_max)
            };
            visits += more;
            self.unconverged_visits += more;
        }
    }

    /// Finds the first row with marks.
    #[inline(always)]
    fn tighten(&mut self, rings: &Rings) {
        let (mut first, end) = self.marked;
        while first < end && self.marks[first] & rings.rows[first].valid == 0 {
            self.marks[first] = 0;
            first += 1;
        }
        self.marked = if first < end { (first, end) } else { NONE };
    }

    /// One pass outwards over the marked rows before row `end`. `COARSE` if the tolerance is not the finest.
    #[inline(always)]
    fn pass<const SAFEGUARDED: bool, const COARSE: bool>(
        &mut self,
        layout: &Layout,
        limits: &Limits,
        end: usize,
        visits_max: u64,
    ) -> u64 {
        let rings = &layout.rings;
        let mut visits = 0;
        let mut row = self.marked.0;
        let level = rings.rows[row].level as usize;
        let end = end.min(rings.rows_of(0..level + WINDOW).end);
        let mut left = usize::MAX;
        while row < self.marked.1.min(end) && visits < visits_max {
            let marks = std::mem::take(&mut self.marks[row]) & rings.rows[row].valid;
            if marks != 0 {
                visits += u64::from(marks.count_ones());
                let (moved, coarse) = self.visit::<SAFEGUARDED, COARSE>(layout, row, marks, limits);
                if moved.any != 0 {
                    left = left.min(self.mark_readers(layout, row, &moved));
                }
                if coarse != 0 {
                    self.coarse[row] |= coarse;
                    self.coarse_rows = with(self.coarse_rows, row);
                    self.coarse_tolerance = self.coarse_tolerance.max(limits.tolerance);
                }
            }
            row += 1;
        }
        // Rows beyond were not visited, and may have marks.
        self.marked.0 = left.min(row);
        visits
    }

    /// Visits the blocks of a row that are set in `marks`: lanes whose residual is above the tolerance take a step.
    /// Returns what moved, and the blocks that did not move but have not converged at the finest tolerance.
    #[inline(always)]
    fn visit<const SAFEGUARDED: bool, const COARSE: bool>(
        &mut self,
        layout: &Layout,
        row: usize,
        marks: u64,
        limits: &Limits,
    ) -> (Moved, u64) {
        let blocks = Blocks::of(layout, &layout.rings.rows[row]);
        let mut all = Moved::default();
        let mut coarse = 0;
        for afterstates in &mut self.afterstates {
            let mut farthest = [0.0; LANES];
            let mut marks = marks;
            while marks != 0 {
                let bit = marks & marks.wrapping_neg();
                let block = marks.trailing_zeros() as usize;
                marks ^= bit;
                let (residual, next) = blocks.measure::<SAFEGUARDED>(afterstates, block, limits.tolerance);
                blocks.write(afterstates, block, &next);
                for (farthest, next) in farthest.iter_mut().zip(next) {
                    *farthest = if next.abs() > *farthest { next.abs() } else { *farthest };
                }
                let moved = lanes_above(&residual, limits.tolerance);
                let if_any = |lanes: u8| if lanes != 0 { bit } else { 0 };
                all.any |= if_any(moved);
                all.first |= if_any(moved & 1);
                all.last |= if_any(moved >> (LANES - 1));
                if COARSE {
                    coarse |= if_any(lanes_above(&residual, limits.finest));
                }
            }
            // No equation reads the row's values while it is visited, so clamping can wait until now.
            if lanes_above(&farthest, layout.magnitude) != 0 {
                blocks.clamp(afterstates, layout.magnitude);
            }
        }
        (all, coarse & !all.any)
    }

    /// Marks the blocks that read the lanes that moved, and their own; updates their ghosts. Returns the first row that
    /// may be marked now.
    #[inline(always)]
    fn mark_readers(&mut self, layout: &Layout, row: usize, moved: &Moved) -> usize {
        let Row { before, after, ring, column, ghosted, ghosted_first, border_ghosts, .. } =
            layout.rings.rows[row];
        for afterstates in &mut self.afterstates {
            for (from, to) in border_ghosts {
                afterstates[to as usize] = afterstates[from as usize];
            }
        }
        let (mut first, mut last) = (before as usize, after as usize);
        self.marks[row] |= moved.any;
        self.marks[first] |= moved.any | moved.first >> 1;
        self.marks[last] |= moved.any | moved.last << 1;
        // Neighbours in the columns beside this one.
        if moved.first & 1 != 0 && column > 0 {
            first -= 1;
            self.marks[first] |= 1 << (BLOCKS - 1);
        }
        if moved.last >> (BLOCKS - 1) != 0 {
            last += 1;
            self.marks[last] |= 1;
        }
        self.marked.1 = self.marked.1.max(last + 1);
        let has_moved = moved.any & ghosted | moved.first & ghosted_first;
        if has_moved != 0 { first.min(self.update_ghosts(layout, ring as usize)) } else { first }
    }

    /// Updates the ghosts of a ring's nodes, and marks the readers of those that change. Returns their first row.
    #[inline(always)]
    fn update_ghosts(&mut self, layout: &Layout, ring: usize) -> usize {
        let mut first = usize::MAX;
        for ghost in layout.rings.ghosts(ring) {
            let mut changes = false;
            for afterstates in &mut self.afterstates {
                changes |= afterstates[ghost.to] != afterstates[ghost.from];
                afterstates[ghost.to] = afterstates[ghost.from];
            }
            // Unpredictable, hence without a branch.
            let (row, bit) = ghost.reader;
            self.marks[row] |= u64::from(changes) << bit;
            self.marked.1 = self.marked.1.max(row + 1);
            first = if changes { first.min(row) } else { first };
        }
        first
    }
}

/// Blocks of a row in which any lane moved, the first lane, or the last, one bit each.
#[derive(Clone, Copy, Debug, Default)]
struct Moved {
    any: u64,
    first: u64,
    last: u64,
}

/// The lanes whose magnitude is above `limit` or not a number, one bit each.
#[inline(always)]
fn lanes_above(lanes: &Lanes, limit: f64) -> u8 {
    let mut set = 0;
    for (lane, number) in lanes.iter().enumerate() {
        let within = number.abs() <= limit;
        set |= u8::from(!within) << lane;
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{DISCOUNT, HARD, SplitMix64};
    use crate::online::rings::{grids, read_by};
    use crate::{Hop, Kind, Leaving, Rules, Site};

    const LOSS: f64 = -900.0;

    /// Flat worlds with goals at all kinds of places, and the goals.
    fn worlds() -> impl Iterator<Item = (usize, GridWorld)> {
        grids().flat_map(|(width, height, goal)| {
            [Leaving::Stays, Leaving::Loses].map(|leaving| {
                let rules = Rules { discount: DISCOUNT, loss: LOSS, leaving, soils: vec![HARD] };
                let mut world = GridWorld::new(width, height, rules).expect("a world in range");
                let site = |kind| Site { kind, payoff: 0.0, slope_east: 0.0, slope_north: 0.0, soil: 0 };
                (0..world.nodes()).for_each(|node| world.set(node, site(Kind::Free)));
                world.set(goal, site(Kind::Goal));
                (goal, world)
            })
        })
    }

    /// P-AT-REST.
    #[test]
    fn who_reads_a_node_that_has_moved_is_marked_and_reads_what_it_is_worth_now() {
        let mut draw = SplitMix64(1);
        for (goal, world) in worlds() {
            let layout = Layout::new(&world);
            let rings = &layout.rings;
            let mut relaxation = Relaxation::<1>::default();
            layout.fill(&world, &vec![0.0; world.nodes()], &mut relaxation.afterstates[0]);
            relaxation.clear(rings);
            let stays = world.rules().leaving == Leaving::Stays;
            for step in 0..world.nodes().min(500) {
                let any = (draw.uniform() * world.nodes() as f64) as usize;
                let node = if world.nodes() <= 500 { step } else { any };
                if node == goal {
                    continue;
                }
                let Some(slot) = rings.slot(node) else { continue };
                relaxation.marks.fill(0);
                relaxation.marked = NONE;
                relaxation.afterstates[0][slot.entry] = 1.0 + step as f64;
                relaxation.mark_around(&layout, slot);
                let beside = Hop::ALL.into_iter().filter_map(|hop| world.neighbour(node, hop));
                for reader in beside.chain([node]).filter(|reader| *reader != goal) {
                    let slot = rings.slot(reader).expect("a slot");
                    let row = rings.at(slot.ring).row(slot.block / BLOCKS);
                    let is_marked =
                        relaxation.marks[row] & rings.rows[row].valid & 1 << (slot.block % BLOCKS);
                    let within = (relaxation.marked.0..relaxation.marked.1).contains(&row);
                    assert!(is_marked != 0 && within, "{reader} beside {node}, around {goal}");
                    for (hop, entry) in read_by(rings, reader) {
                        let is_worth = |node: usize| match rings.slot(node) {
                            Some(slot) => relaxation.afterstates[0][slot.entry],
                            None => 0.0,
                        };
                        let expected = match world.neighbour(reader, hop) {
                            Some(to) => is_worth(to),
                            None if stays => is_worth(reader),
                            None => LOSS,
                        };
                        let value = relaxation.afterstates[0][entry];
                        assert_eq!(value, expected, "{hop:?} of {reader} beside {node}, around {goal}");
                    }
                }
            }
        }
    }

    /// P-ENCLOSED.
    #[test]
    fn a_level_that_is_raised_is_read_as_such_from_everywhere() {
        for (goal, world) in worlds().filter(|(_, world)| world.nodes() < 10_000) {
            let layout = Layout::new(&world);
            let mut relaxation = Relaxation::<2>::default();
            for afterstates in &mut relaxation.afterstates {
                layout.fill(&world, &vec![0.0; world.nodes()], afterstates);
            }
            for level in (0..layout.rings.levels).step_by(3) {
                relaxation.raise_level(&layout, level, [level as f64, -1.0]);
            }
            let raised =
                |node: usize| layout.rings.level(node).filter(|level| level % 3 == 0 && node != goal);
            for node in (0..world.nodes()).filter(|&node| node != goal) {
                for (hop, entry) in read_by(&layout.rings, node) {
                    let expected = match world.neighbour(node, hop) {
                        None if world.rules().leaving == Leaving::Loses => [LOSS; 2],
                        to => raised(to.unwrap_or(node)).map_or([0.0; 2], |level| [level as f64, -1.0]),
                    };
                    let afterstates = relaxation.afterstates.each_ref().map(|afterstates| afterstates[entry]);
                    assert_eq!(afterstates, expected, "{hop:?} of {node}, around {goal}");
                }
            }
        }
    }
}
