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
use super::rings::{LANES, Rings, Seat};

/// Rings of a pass.
const WINDOW: usize = 40;

/// Worths and what is marked in them.
#[derive(Clone, Debug, Default)]
pub(super) struct Relaxation {
    pub worths: Vec<f64>,
    marks: Vec<u64>,
    /// Levels outside of which nothing is marked: from the first to before the second.
    levels: (usize, usize),
}

/// What a relaxation may do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Residual to come to rest at.
    pub tolerance: f64,
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

impl Relaxation {
    /// Nothing marked.
    pub fn clear(&mut self, rings: &Rings) {
        self.marks.clear();
        self.marks.resize(rings.words, 0);
        self.levels = NONE;
    }

    /// Whether nothing is marked below `frozen_from`.
    pub fn at_rest(&self, frozen_from: usize) -> bool {
        self.levels.0 >= self.levels.1.min(frozen_from)
    }

    #[inline(always)]
    fn mark(&mut self, rings: &Rings, ring: usize, block: usize) {
        if let Some((word, bit)) = rings.mark(ring, block) {
            self.marks[word] |= 1 << bit;
        }
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
                for block in rings.blocks(ring) {
                    self.mark(rings, ring, block);
                }
                self.levels = with(self.levels, level);
            }
        }
    }

    /// Adds `rise` to the worths of a level's free nodes; marks nothing.
    pub fn raise_level(&mut self, field: &Field, level: usize, rise: f64) {
        let rings = &field.rings;
        for quadrant in rings.quadrants() {
            let Some(ring) = rings.ring(quadrant, level) else { continue };
            for (_, place) in rings.nodes(quadrant, level) {
                if field.is_free(place) {
                    self.worths[place] += rise;
                }
            }
            for mirror in rings.mirrors(ring) {
                if !(mirror.rim && field.loses) {
                    self.worths[mirror.to] = self.worths[mirror.from];
                }
            }
        }
    }

    /// The largest value of `of` over the residuals TW − W of the marked blocks of the levels from `first`
    /// to before `end`, at least 0. Visits nothing, marks nothing.
    pub fn worst(&self, field: &Field, levels: Range<usize>, of: impl Fn(f64) -> f64) -> f64 {
        let mut worst = 0.0_f64;
        for level in levels.start.max(self.levels.0)..levels.end.min(self.levels.1) {
            for quadrant in field.rings.quadrants() {
                let Some(ring) = field.rings.ring(quadrant, level) else { continue };
                let (words, first) = field.rings.marks(ring);
                for (index, word) in words.enumerate() {
                    for bit in (0..64).filter(|bit| self.marks[word] & (1 << bit) != 0) {
                        let (residual, _) = self.measure(field, ring, first + 64 * index + bit);
                        worst = residual.into_iter().map(&of).fold(worst, f64::max);
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
                let (words, first) = field.rings.marks(ring);
                for (index, word) in words.enumerate() {
                    let mut marks = std::mem::take(&mut self.marks[word]);
                    while marks != 0 {
                        let block = first + 64 * index + marks.trailing_zeros() as usize;
                        marks &= marks - 1;
                        visits += 1;
                        if self.visit(field, ring, block, limits.tolerance) {
                            left = with(with(left, level.saturating_sub(1)), level + 1);
                            self.levels.1 = self.levels.1.max(level + 2);
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

    /// Visits a block; whether a lane stepped.
    #[inline(always)]
    fn visit(&mut self, field: &Field, ring: usize, block: usize, tolerance: f64) -> bool {
        let (residual, step) = self.measure(field, ring, block);
        let place = field.rings.place(ring, block);
        let mut worths = *lanes(&self.worths, place);
        let mut changed = 0_u32;
        let magnitude = field.magnitude;
        for lane in 0..LANES {
            let moves = residual[lane] > tolerance || -residual[lane] > tolerance;
            let worth = worths[lane] + step[lane];
            let worth = if worth > magnitude { magnitude } else { worth };
            let worth = if worth < -magnitude { -magnitude } else { worth };
            worths[lane] = if moves { worth } else { worths[lane] };
            changed |= u32::from(moves) << lane;
        }
        if changed == 0 {
            return false;
        }
        self.worths[place..place + LANES].copy_from_slice(&worths);
        self.touched(field, ring, block, changed);
        true
    }

    /// Residuals and steps of a block.
    #[inline(always)]
    fn measure(&self, field: &Field, ring: usize, block: usize) -> (Lanes, Lanes) {
        let rings = &field.rings;
        let place = rings.place(ring, block);
        let (inwards, outwards) = (rings.place(ring - 1, block), rings.place(ring + 1, block));
        let around = Around {
            here: lanes(&self.worths, place),
            in_u: lanes(&self.worths, inwards),
            in_v: lanes(&self.worths, inwards - 1),
            out_u: lanes(&self.worths, outwards),
            out_v: lanes(&self.worths, outwards + 1),
        };
        let soil = match field.soil(place) {
            Ok(soil) => ScatteredLanes::uniform(soil),
            Err(classes) => ScatteredLanes::each(field.soils(), classes),
        };
        backup(&soil, &field.ground(place), &around)
    }

    /// Marks what reads the lanes of a block that are set in `changed`, and the block; brings their mirrors
    /// up to date.
    #[inline(always)]
    fn touched(&mut self, field: &Field, ring: usize, block: usize, changed: u32) {
        let rings = &field.rings;
        self.mark(rings, ring, block);
        self.mark(rings, ring - 1, block);
        self.mark(rings, ring + 1, block);
        if changed & 1 != 0 {
            self.mark(rings, ring - 1, block - 1);
        }
        if changed & (1 << (LANES - 1)) != 0 {
            self.mark(rings, ring + 1, block + 1);
        }
        let place = rings.place(ring, block);
        for mirror in rings.mirrors(ring) {
            let lane = mirror.from.wrapping_sub(place);
            if lane < LANES && changed & (1 << lane) != 0 {
                if !(mirror.rim && field.loses) {
                    self.worths[mirror.to] = self.worths[mirror.from];
                }
                self.mark(rings, mirror.reader.0, mirror.reader.1);
            }
        }
    }
}
