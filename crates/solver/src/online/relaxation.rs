//! Worths brought back to rest where something changed: active-set Gauss–Seidel from ring to ring.
//!
//! A block is *marked* if its nodes' residuals |TW − W| are not known to be at most the tolerance. A visit
//! measures them. Lanes above the tolerance take a step, and the blocks whose residuals that step touches
//! are marked: this one, and those of the lanes' neighbours. Marks are kept 64 to a word, a block at the
//! same bit on every ring, so that a word's visits mark their neighbours at once. If no lane steps, the block is at rest: its
//! residuals are known, and remain so until a neighbour or the ground changes, which marks it again. When
//! nothing is marked, every node's residual is at most the tolerance, measured after the last change of
//! any of its inputs: a proof as strong as a full sweep, whatever was visited.
//!
//! Visits go outwards, the way news of the goal travels: a change crosses all it reaches in one pass. What
//! that order leaves over are slips back towards the goal, one a pass; so a pass goes no further than
//! [`WINDOW`] rings beyond the first marked one, lest far rings be visited again for every correction of
//! near ones.
//!
//! On some steep worlds these steps go round in circles. After [`BOLD_SWEEPS`] without rest they are careful
//! ones ([`backup`]), which come to rest, though slowly; after [`SWEEPS_MAX`] the relaxation is *stuck* and
//! visits nothing more until it begins anew.

use std::ops::Range;

use super::field::{Field, lanes};
use super::kernel::{Around, Lanes, backup};
use super::rings::{LANES, Rings, Seat};
use crate::World;

/// Rings of a pass.
const WINDOW: usize = 40;

/// Sweeps without rest after which steps are careful.
const BOLD_SWEEPS: u64 = 64;

/// Sweeps without rest after which it is given up.
const SWEEPS_MAX: u64 = 1024;

/// One or several fields of worths on one world, and what is marked in them: a block if it is in any.
#[derive(Clone, Debug)]
pub(super) struct Relaxation<const FIELDS: usize> {
    pub worths: [Vec<f64>; FIELDS],
    marks: Vec<u64>,
    /// Levels outside of which nothing is marked: from the first to before the second.
    levels: (usize, usize),
    /// Blocks at rest at a tolerance, `rough_at` at most, that is not the finest.
    rough: Vec<u64>,
    rough_levels: (usize, usize),
    rough_at: f64,
    /// Visits since the last rest.
    restless: u64,
}

/// What a relaxation may do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Residual to come to rest at.
    pub tolerance: f64,
    /// Residual that nobody will ask more than.
    pub finest: f64,
    /// First level that stays as it is.
    pub frozen_from: usize,
    /// Most blocks to visit, but for the ring that exceeds it.
    pub visits_max: u64,
}

/// No level.
const NONE: (usize, usize) = (usize::MAX, 0);

fn with(levels: (usize, usize), level: usize) -> (usize, usize) {
    (levels.0.min(level), levels.1.max(level + 1))
}

impl<const FIELDS: usize> Default for Relaxation<FIELDS> {
    fn default() -> Self {
        Self {
            worths: std::array::from_fn(|_| Vec::new()),
            marks: Vec::new(),
            levels: NONE,
            rough: Vec::new(),
            rough_levels: NONE,
            rough_at: 0.0,
            restless: 0,
        }
    }
}

impl<const FIELDS: usize> Relaxation<FIELDS> {
    /// Nothing marked.
    pub fn clear(&mut self, rings: &Rings) {
        for marks in [&mut self.marks, &mut self.rough] {
            marks.clear();
            marks.resize(rings.valid.len(), 0);
        }
        (self.levels, self.rough_levels, self.rough_at) = (NONE, NONE, 0.0);
        self.restless = 0;
    }

    /// Begins with the row-major values of `world` in every field, all marked.
    pub fn begin(&mut self, field: &Field, world: &World, values: &[f64]) {
        for worths in &mut self.worths {
            field.worths(world, values, worths);
        }
        self.clear(&field.rings);
        for level in 0..field.rings.levels {
            self.touch_level(&field.rings, level);
        }
    }

    /// Becomes what `other` is, each field its first.
    pub fn take_over<const OTHERS: usize>(&mut self, other: &Relaxation<OTHERS>) {
        for worths in &mut self.worths {
            worths.clone_from(&other.worths[0]);
        }
        self.marks.clone_from(&other.marks);
        self.levels = other.levels;
        self.rough.clone_from(&other.rough);
        (self.rough_levels, self.rough_at) = (other.rough_levels, other.rough_at);
        self.restless = other.restless;
    }

    /// Whether nothing is marked below `frozen_from`.
    pub fn at_rest(&self, frozen_from: usize) -> bool {
        self.levels.0 >= self.levels.1.min(frozen_from)
    }

    /// Whether it has been given up.
    pub fn is_stuck(&self, field: &Field) -> bool {
        self.restless > SWEEPS_MAX * field.blocks()
    }

    /// Marks a node's block and those of its neighbours: its worth has been changed, or its ground.
    pub fn touch(&mut self, field: &Field, seat: Seat, level: usize) {
        let at = |lane: usize| u64::from(seat.place % LANES == lane) << (seat.block % 64);
        let moved = Moved { any: 1 << (seat.block % 64), first: at(0), last: at(LANES - 1) };
        self.touched(field, seat.ring, seat.block / 64, &moved);
        self.levels = with(with(self.levels, level.saturating_sub(1)), level + 1);
    }

    /// Marks all of a level.
    pub fn touch_level(&mut self, rings: &Rings, level: usize) {
        for quadrant in rings.quadrants() {
            if let Some(ring) = rings.ring(quadrant, level) {
                for word in rings.words(ring) {
                    self.marks[word] = rings.valid[word];
                }
                self.levels = with(self.levels, level);
            }
        }
    }

    /// The levels from `level` on that may bear marks.
    pub fn marked_from(&self, level: usize) -> Range<usize> {
        level.max(self.levels.0)..self.levels.1.max(level)
    }

    /// Unmarks all levels from `level` on.
    pub fn unmark_from(&mut self, rings: &Rings, level: usize) {
        for level in self.marked_from(level) {
            for ring in rings.quadrants().filter_map(|quadrant| rings.ring(quadrant, level)) {
                self.marks[rings.words(ring)].fill(0);
            }
        }
        self.levels.1 = self.levels.1.min(level);
        if self.levels.0 >= self.levels.1 {
            self.levels = NONE;
        }
    }

    /// Marks what is at rest at a tolerance above `tolerance`, before `frozen_from`.
    pub fn refine(&mut self, rings: &Rings, tolerance: f64, frozen_from: usize) {
        if self.rough_at <= tolerance {
            return;
        }
        let levels = self.rough_levels.0..self.rough_levels.1.min(frozen_from);
        for level in levels.clone() {
            for ring in rings.quadrants().filter_map(|quadrant| rings.ring(quadrant, level)) {
                for word in rings.words(ring) {
                    self.marks[word] |= std::mem::take(&mut self.rough[word]);
                }
            }
        }
        if !levels.is_empty() {
            self.levels = with(with(self.levels, levels.start), levels.end - 1);
        }
        (self.rough_levels, self.rough_at) = (NONE, 0.0);
    }

    /// Adds each field's rise to its worths of a level's free nodes; marks nothing.
    pub fn raise_level(&mut self, field: &Field, level: usize, rises: [f64; FIELDS]) {
        let rings = &field.rings;
        for quadrant in rings.quadrants() {
            let Some(ring) = rings.ring(quadrant, level) else { continue };
            let places = rings.at(ring).places();
            for (worths, rise) in self.worths.iter_mut().zip(rises) {
                for (worth, free) in worths[places.clone()].iter_mut().zip(field.free(places.clone())) {
                    let raised = (*worth + rise).clamp(-field.magnitude, field.magnitude);
                    *worth = if free { raised } else { *worth };
                }
                for mirror in rings.mirrors(ring) {
                    if !(mirror.rim && field.loses) {
                        worths[mirror.to] = worths[mirror.from];
                    }
                }
            }
        }
    }

    /// The largest value of `of` over the fields' residuals TW − W in the marked blocks of `levels`, at
    /// least 0. Visits nothing, marks nothing.
    pub fn worst(&self, field: &Field, levels: Range<usize>, of: impl Fn([f64; FIELDS]) -> f64) -> f64 {
        let mut worst = 0.0_f64;
        for level in levels.start.max(self.levels.0)..levels.end.min(self.levels.1) {
            for quadrant in field.rings.quadrants() {
                let Some(ring) = field.rings.ring(quadrant, level) else { continue };
                for column in field.rings.at(ring).columns() {
                    let word = field.rings.at(ring).word(column);
                    let marks = self.marks[word] & field.rings.valid[word];
                    for bit in (0..64).filter(|bit| marks & (1 << bit) != 0) {
                        let block = Block::new(field, ring, 64 * column + bit);
                        let residuals =
                            self.worths.each_ref().map(|worths| block.measure::<false>(field, worths, 0.0).0);
                        let of_lane = |lane: usize| of(residuals.map(|residual| residual[lane]));
                        worst = (0..LANES).map(of_lane).fold(worst, f64::max);
                    }
                }
            }
        }
        worst
    }

    /// Relaxes until nothing is marked below `limits.frozen_from`, the visits run out, or it is stuck. Returns
    /// the visits.
    #[inline(always)]
    pub fn relax(&mut self, field: &Field, limits: &Limits) -> u64 {
        let mut visits = 0;
        while !self.at_rest(limits.frozen_from) && visits < limits.visits_max && !self.is_stuck(field) {
            let more = self.pass(field, limits, limits.visits_max - visits);
            visits += more;
            self.restless += more;
        }
        if self.at_rest(limits.frozen_from) {
            self.restless = 0;
        }
        visits
    }

    /// One pass outwards over what is marked.
    #[inline(always)]
    fn pass(&mut self, field: &Field, limits: &Limits, visits_max: u64) -> u64 {
        let mut visits = 0;
        let mut left = NONE;
        let mut level = self.levels.0;
        let window = level + WINDOW;
        let careful = self.restless > BOLD_SWEEPS * field.blocks();
        while level < self.levels.1 && level < window && visits < visits_max {
            if level >= limits.frozen_from {
                break;
            }
            for quadrant in 0..4 {
                let Some(ring) = field.rings.ring(quadrant, level) else { continue };
                for column in field.rings.at(ring).columns() {
                    let word = field.rings.at(ring).word(column);
                    let marks = std::mem::take(&mut self.marks[word]) & field.rings.valid[word];
                    if marks == 0 {
                        continue;
                    }
                    visits += u64::from(marks.count_ones());
                    let (moved, rough) = if careful {
                        self.visit_carefully(field, ring, column, marks, limits)
                    } else {
                        self.visit::<false>(field, ring, column, marks, limits)
                    };
                    if moved.any != 0 {
                        self.touched(field, ring, column, &moved);
                        left = with(with(left, level.saturating_sub(1)), level + 1);
                        self.levels.1 = self.levels.1.max(level + 2);
                    }
                    if rough != 0 {
                        self.rough[word] |= rough;
                        self.rough_levels = with(self.rough_levels, level);
                        self.rough_at = self.rough_at.max(limits.tolerance);
                    }
                }
            }
            level += 1;
        }
        // What lies beyond has not been looked at; a ring of it may bear marks already.
        if level < self.levels.1 {
            left = (left.0.min(level), self.levels.1);
        }
        self.levels = left;
        visits
    }

    /// The same with careful steps: seldom needed, and kept out of the way.
    #[inline(never)]
    fn visit_carefully(
        &mut self,
        field: &Field,
        ring: usize,
        column: usize,
        marks: u64,
        limits: &Limits,
    ) -> (Moved, u64) {
        self.visit::<true>(field, ring, column, marks, limits)
    }

    /// Visits the blocks of a column that are set in `marks`: lanes whose residual is above the tolerance step.
    /// What moved, and the blocks that did not but are short of the finest tolerance.
    #[inline(always)]
    fn visit<const CAREFUL: bool>(
        &mut self,
        field: &Field,
        ring: usize,
        column: usize,
        marks: u64,
        limits: &Limits,
    ) -> (Moved, u64) {
        let first = Block::new(field, ring, 64 * column);
        let magnitude = field.magnitude;
        let mut all = Moved::default();
        let mut rough = 0;
        for worths in &mut self.worths {
            let mut marks = marks;
            while marks != 0 {
                let bit = marks & marks.wrapping_neg();
                let at = first.onwards(marks.trailing_zeros() as usize);
                marks ^= bit;
                let (residual, step) = at.measure::<CAREFUL>(field, worths, limits.tolerance);
                for (worth, step) in worths[at.place..at.place + LANES].iter_mut().zip(step) {
                    let next = *worth + step;
                    let next = if next > magnitude { magnitude } else { next };
                    *worth = if next < -magnitude { -magnitude } else { next };
                }
                let moved = beyond(&residual, limits.tolerance);
                let if_any = |lanes: u8| if lanes != 0 { bit } else { 0 };
                all.any |= if_any(moved);
                all.first |= if_any(moved & 1);
                all.last |= if_any(moved >> (LANES - 1));
                rough |= if_any(beyond(&residual, limits.finest));
            }
        }
        (all, rough & !all.any)
    }

    /// Marks what reads the lanes that moved, and their blocks; brings their mirrors up to date.
    #[inline(always)]
    fn touched(&mut self, field: &Field, ring: usize, column: usize, moved: &Moved) {
        let rings = &field.rings;
        let word = |ring: usize| rings.at(ring).word(column);
        let (inwards, here, outwards) = (word(ring - 1), word(ring), word(ring + 1));
        self.marks[here] |= moved.any;
        self.marks[inwards] |= moved.any | moved.first >> 1;
        self.marks[outwards] |= moved.any | moved.last << 1;
        // Neighbours in the columns beside this one.
        if moved.first & 1 != 0 && column > 0 {
            self.marks[inwards - 1] |= 1 << 63;
        }
        if moved.last >> 63 != 0 {
            self.marks[outwards + 1] |= 1;
        }
        if moved.any & rings.mirrored[here] != 0 {
            self.mirror(field, ring);
        }
    }

    /// Brings the mirrors of a ring's nodes up to date, and marks who reads those that change.
    fn mirror(&mut self, field: &Field, ring: usize) {
        for mirror in field.rings.mirrors(ring) {
            // What leaving the grid loses is worth the same whatever moves.
            if mirror.rim && field.loses {
                continue;
            }
            let mut changes = false;
            for worths in &mut self.worths {
                changes |= worths[mirror.to] != worths[mirror.from];
                worths[mirror.to] = worths[mirror.from];
            }
            if changes {
                let (ring, block) = mirror.reader;
                self.marks[field.rings.at(ring).word(block / 64)] |= 1 << (block % 64);
            }
        }
    }
}

/// Blocks of a column in which lanes moved, a bit each: any lane, the first, the last.
#[derive(Clone, Copy, Debug, Default)]
struct Moved {
    any: u64,
    first: u64,
    last: u64,
}

/// The lanes whose magnitude is above `limit` or no number, a bit each.
#[inline(always)]
fn beyond(lanes: &Lanes, limit: f64) -> u8 {
    let mut set = 0;
    for (lane, number) in lanes.iter().enumerate() {
        let within = number.abs() <= limit;
        set |= u8::from(!within) << lane;
    }
    set
}

/// A block and the places that its equations read.
struct Block {
    place: usize,
    inwards: usize,
    outwards: usize,
}

impl Block {
    #[inline(always)]
    fn new(field: &Field, ring: usize, block: usize) -> Self {
        let rings = &field.rings;
        Self {
            place: rings.at(ring).place(block),
            inwards: rings.at(ring - 1).place(block),
            outwards: rings.at(ring + 1).place(block),
        }
    }

    /// The block so many blocks farther along the ring.
    #[inline(always)]
    fn onwards(&self, blocks: usize) -> Self {
        let places = blocks * LANES;
        Self { place: self.place + places, inwards: self.inwards + places, outwards: self.outwards + places }
    }

    /// Residuals and steps of one field.
    #[inline(always)]
    fn measure<const CAREFUL: bool>(&self, field: &Field, worths: &[f64], tolerance: f64) -> (Lanes, Lanes) {
        let around = Around {
            here: lanes(worths, self.place),
            in_u: lanes(worths, self.inwards),
            in_v: lanes(worths, self.inwards - 1),
            out_u: lanes(worths, self.outwards),
            out_v: lanes(worths, self.outwards + 1),
        };
        let block = self.place / LANES;
        backup::<CAREFUL>(field.soils(block), field.ground(block), &around, tolerance)
    }
}
