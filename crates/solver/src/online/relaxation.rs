//! Worths brought back to rest where something changed: active-set Gauss–Seidel from ring to ring.
//!
//! A block is *marked* if its nodes' residuals |TW − W| are not known to be at most the tolerance. A visit
//! measures them. Lanes above the tolerance take a step, and the blocks whose residuals that step touches
//! are marked: this one, and those of the lanes' neighbours. If no lane steps, the block is at rest: its
//! residuals are known, and remain so until a neighbour or the ground changes, which marks it again. When
//! nothing is marked, every node's residual is at most the tolerance, measured after the last change of
//! any of its inputs: a proof as strong as a full sweep, whatever was visited.
//!
//! Visits go outwards, the way news of the goal travels: a change crosses all it reaches in one pass. What
//! that order leaves over are slips back towards the goal, one a pass; so a pass goes no further than
//! [`WINDOW`] rings beyond the first marked one, lest far rings be visited again for every correction of
//! near ones.

use std::ops::Range;

use super::field::{Field, lanes};
use super::kernel::{Around, Lanes, ScatteredLanes, backup};
use super::rings::{LANES, Ring, Rings, Seat};

/// Rings of a pass.
const WINDOW: usize = 40;

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
        }
    }
}

impl<const FIELDS: usize> Relaxation<FIELDS> {
    /// Nothing marked.
    pub fn clear(&mut self, rings: &Rings) {
        for marks in [&mut self.marks, &mut self.rough] {
            marks.clear();
            marks.resize(rings.words, 0);
        }
        (self.levels, self.rough_levels, self.rough_at) = (NONE, NONE, 0.0);
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
    }

    /// Whether nothing is marked below `frozen_from`.
    pub fn at_rest(&self, frozen_from: usize) -> bool {
        self.levels.0 >= self.levels.1.min(frozen_from)
    }

    /// Marks a node's block and those of its neighbours: its worth has been changed, or its ground.
    pub fn touch(&mut self, field: &Field, seat: Seat, level: usize) {
        self.touched(field, seat.ring, seat.block, 1 << (seat.place % LANES));
        self.levels = with(with(self.levels, level.saturating_sub(1)), level + 1);
    }

    /// Marks all of a level.
    pub fn touch_level(&mut self, rings: &Rings, level: usize) {
        for quadrant in rings.quadrants() {
            if let Some(ring) = rings.ring(quadrant, level) {
                for block in rings.at(ring).blocks() {
                    self.mark(rings.at(ring), block);
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
                self.marks[rings.at(ring).marks().0].fill(0);
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
                for word in rings.at(ring).marks().0 {
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
                let (words, first) = field.rings.at(ring).marks();
                for (index, word) in words.enumerate() {
                    for bit in (0..64).filter(|bit| self.marks[word] & (1 << bit) != 0) {
                        let block = Block::new(field, ring, first + 64 * index + bit);
                        let residuals = self.worths.each_ref().map(|worths| block.measure(field, worths).0);
                        let of_lane = |lane: usize| of(residuals.map(|residual| residual[lane]));
                        worst = (0..LANES).map(of_lane).fold(worst, f64::max);
                    }
                }
            }
        }
        worst
    }

    /// Relaxes until nothing is marked below `limits.frozen_from`, or the visits run out. Returns the visits.
    #[inline(always)]
    pub fn relax(&mut self, field: &Field, limits: &Limits) -> u64 {
        let mut visits = 0;
        while !self.at_rest(limits.frozen_from) && visits < limits.visits_max {
            visits += self.pass(field, limits, limits.visits_max - visits);
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
        while level < self.levels.1 && level < window && visits < visits_max {
            if level >= limits.frozen_from {
                break;
            }
            for quadrant in 0..4 {
                let Some(ring) = field.rings.ring(quadrant, level) else { continue };
                let (words, first) = field.rings.at(ring).marks();
                for (index, word) in words.enumerate() {
                    let mut marks = std::mem::take(&mut self.marks[word]);
                    while marks != 0 {
                        let bit = marks.trailing_zeros();
                        let block = first + 64 * index + bit as usize;
                        marks &= marks - 1;
                        visits += 1;
                        let short = self.visit(field, ring, block, limits.tolerance);
                        if short > limits.tolerance {
                            left = with(with(left, level.saturating_sub(1)), level + 1);
                            self.levels.1 = self.levels.1.max(level + 2);
                        } else if short > limits.finest {
                            self.rough[word] |= 1 << bit;
                            self.rough_levels = with(self.rough_levels, level);
                            self.rough_at = self.rough_at.max(limits.tolerance);
                        }
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

    /// Visits a block: lanes whose residual is above the tolerance step. The largest residual, at least.
    #[inline(always)]
    fn visit(&mut self, field: &Field, ring: usize, block: usize, tolerance: f64) -> f64 {
        let at = Block::new(field, ring, block);
        let magnitude = field.magnitude;
        let mut changed = 0;
        let mut short = 0.0_f64;
        for worths in &mut self.worths {
            let (residual, step) = at.measure(field, worths);
            let here = *lanes(worths, at.place);
            let mut next = [0.0; LANES];
            let mut moved = [0_u64; LANES];
            for lane in 0..LANES {
                let moves = residual[lane].abs() > tolerance;
                let worth = here[lane] + step[lane];
                let worth = if worth > magnitude { magnitude } else { worth };
                let worth = if worth < -magnitude { -magnitude } else { worth };
                next[lane] = if moves { worth } else { here[lane] };
                moved[lane] = if moves { 1 << lane } else { 0 };
            }
            let mut most = residual.map(f64::abs);
            for half in [8, 4, 2, 1] {
                for lane in 0..half {
                    let other = most[lane + half];
                    most[lane] = if other > most[lane] { other } else { most[lane] };
                }
            }
            short = if most[0] > short { most[0] } else { short };
            worths[at.place..at.place + LANES].copy_from_slice(&next);
            changed |= moved.into_iter().fold(0, |all, lane| all | lane);
        }
        if changed != 0 {
            self.touched(field, ring, block, changed);
        }
        short
    }

    #[inline(always)]
    fn mark(&mut self, ring: &Ring, block: usize) {
        if let Some((word, bit)) = ring.mark(block) {
            self.marks[word] |= 1 << bit;
        }
    }

    /// Marks what reads the lanes of a block that are set in `changed`, and the block; brings their mirrors
    /// up to date.
    #[inline(always)]
    fn touched(&mut self, field: &Field, ring: usize, block: usize, changed: u64) {
        let rings = &field.rings;
        let (inwards, here, outwards) = (rings.at(ring - 1), rings.at(ring), rings.at(ring + 1));
        self.mark(here, block);
        self.mark(inwards, block);
        self.mark(outwards, block);
        if changed & 1 != 0 {
            self.mark(inwards, block - 1);
        }
        if changed & (1 << (LANES - 1)) != 0 {
            self.mark(outwards, block + 1);
        }
        // Only the ends of a ring have mirrors.
        if here.blocks().contains(&(block + 1)) && here.blocks().contains(&(block - 1)) {
            return;
        }
        let place = here.place(block);
        for mirror in rings.mirrors(ring) {
            let lane = mirror.from.wrapping_sub(place);
            if lane < LANES && changed & (1 << lane) != 0 {
                if !(mirror.rim && field.loses) {
                    for worths in &mut self.worths {
                        worths[mirror.to] = worths[mirror.from];
                    }
                }
                self.mark(rings.at(mirror.reader.0), mirror.reader.1);
            }
        }
    }
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

    /// Residuals and steps of one field.
    #[inline(always)]
    fn measure(&self, field: &Field, worths: &[f64]) -> (Lanes, Lanes) {
        let around = Around {
            here: lanes(worths, self.place),
            in_u: lanes(worths, self.inwards),
            in_v: lanes(worths, self.inwards - 1),
            out_u: lanes(worths, self.outwards),
            out_v: lanes(worths, self.outwards + 1),
        };
        let ground = field.ground(self.place);
        // Apart, so that where a block is of one soil its numbers stay in registers.
        match field.soil(self.place) {
            Ok(soil) => backup(&ScatteredLanes::uniform(soil), &ground, &around),
            Err(classes) => backup(&ScatteredLanes::each(field.soils(), classes), &ground, &around),
        }
    }
}
