//! Worths brought back to rest where something changed: active-set Gauss–Seidel from ring to ring.
//!
//! A block is *marked* if its nodes' residuals |TW − W| are not known to be at most the tolerance. A visit
//! measures them. Lanes above the tolerance take a step, and the blocks whose residuals that step touches
//! are marked: this one, and those of the lanes' neighbours. Marks are kept 64 to a word, a block at the
//! same bit on every ring, so that a row's visits mark their neighbours at once; and words in the order of
//! visits, so that a pass runs through them. If no lane steps, the block is at rest: its residuals are known,
//! and remain so until a neighbour or the ground changes, which marks it again. When nothing is marked, every
//! node's residual is at most the tolerance, measured after the last change of any of its inputs: a proof as
//! strong as a full sweep, whatever was visited.
//!
//! Visits go outwards, the way news of the goal travels: a change crosses all it reaches in one pass. What
//! that order leaves over are slips back towards the goal, one a pass; so a pass goes no further than
//! [`WINDOW`] levels beyond the first marked one, lest far ones be visited again for every correction of
//! near ones.
//!
//! On some steep worlds these steps go round in circles. After [`BOLD_SWEEPS`] without rest they are careful
//! ones ([`backup`]), which come to rest, though slowly; after [`SWEEPS_MAX`] the relaxation is *stuck* and
//! visits nothing more until it begins anew.

use std::ops::Range;

use super::blocks::Blocks;
use super::field::Field;
use super::kernel::Lanes;
use super::rings::{BLOCKS, LANES, Rings, Row, Seat};
use crate::World;

/// Levels of a pass.
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
    /// Rows outside of which nothing is marked: from the first to before the second.
    marked: (usize, usize),
    /// Blocks at rest at a tolerance, `rough_at` at most, that is not the finest.
    rough: Vec<u64>,
    rough_rows: (usize, usize),
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
    /// Most blocks to visit, but for the row that exceeds it.
    pub visits_max: u64,
}

/// No row.
const NONE: (usize, usize) = (usize::MAX, 0);

fn with(rows: (usize, usize), row: usize) -> (usize, usize) {
    (rows.0.min(row), rows.1.max(row + 1))
}

impl<const FIELDS: usize> Default for Relaxation<FIELDS> {
    fn default() -> Self {
        Self {
            worths: std::array::from_fn(|_| Vec::new()),
            marks: Vec::new(),
            marked: NONE,
            rough: Vec::new(),
            rough_rows: NONE,
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
            marks.resize(rings.rows.len(), 0);
        }
        (self.marked, self.rough_rows, self.rough_at) = (NONE, NONE, 0.0);
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
        self.marked = other.marked;
        self.rough.clone_from(&other.rough);
        (self.rough_rows, self.rough_at) = (other.rough_rows, other.rough_at);
        self.restless = other.restless;
    }

    /// Whether nothing is marked below `frozen_from`.
    pub fn at_rest(&self, rings: &Rings, frozen_from: usize) -> bool {
        self.marked.0 >= self.marked.1.min(rings.rows_of(0..frozen_from).end)
    }

    /// Whether it has been given up.
    pub fn is_stuck(&self, rings: &Rings) -> bool {
        self.restless > SWEEPS_MAX * rings.blocks
    }

    /// Marks a node's block and those of its neighbours: its worth has been changed, or its ground.
    pub fn touch(&mut self, field: &Field, seat: Seat) {
        let row = field.rings.at(seat.ring).row(seat.block / BLOCKS);
        let at = |lane: usize| u64::from(seat.place % LANES == lane) << (seat.block % BLOCKS);
        let moved = Moved { any: 1 << (seat.block % BLOCKS), first: at(0), last: at(LANES - 1) };
        let start = self.touched(field, row, &moved);
        self.marked = with(self.marked, start);
    }

    /// Marks all of a level.
    pub fn touch_level(&mut self, rings: &Rings, level: usize) {
        for row in rings.rows_of(level..level + 1) {
            self.marks[row] = rings.rows[row].valid;
            self.marked = with(self.marked, row);
        }
    }

    /// The levels from `level` on that may bear marks.
    pub fn marked_from(&self, rings: &Rings, level: usize) -> Range<usize> {
        let rows = self.marked.0.max(rings.rows_of(0..level).end)..self.marked.1;
        match rings.rows.get(rows) {
            Some([first, .., last]) => first.level as usize..last.level as usize + 1,
            Some([row]) => row.level as usize..row.level as usize + 1,
            _ => level..level,
        }
    }

    /// Unmarks all levels from `level` on.
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

    /// Marks what is at rest at a tolerance above `tolerance`, before `frozen_from`.
    pub fn refine(&mut self, rings: &Rings, tolerance: f64, frozen_from: usize) {
        if self.rough_at <= tolerance {
            return;
        }
        for row in self.rough_rows.0..self.rough_rows.1.min(rings.rows_of(0..frozen_from).end) {
            self.marks[row] |= std::mem::take(&mut self.rough[row]);
            self.marked = with(self.marked, row);
        }
        (self.rough_rows, self.rough_at) = (NONE, 0.0);
    }

    /// Adds each field's rise to its worths of a level's free nodes; marks nothing.
    pub fn raise_level(&mut self, field: &Field, level: usize, rises: [f64; FIELDS]) {
        let rings = &field.rings;
        for sector in rings.sectors() {
            let Some(ring) = rings.ring(sector, level) else { continue };
            let places = rings.at(ring).places();
            for (worths, rise) in self.worths.iter_mut().zip(rises) {
                for (worth, free) in worths[places.clone()].iter_mut().zip(field.free(places.clone())) {
                    let raised = (*worth + rise).clamp(-field.magnitude, field.magnitude);
                    *worth = if free { raised } else { *worth };
                }
                for mirror in rings.mirrors(ring) {
                    worths[mirror.to] = worths[mirror.from];
                }
            }
        }
    }

    /// The largest value of `of` over the fields' residuals TW − W in the marked blocks of `levels`, at
    /// least 0. Visits nothing, marks nothing.
    pub fn worst(&self, field: &Field, levels: Range<usize>, of: impl Fn([f64; FIELDS]) -> f64) -> f64 {
        let mut worst = 0.0_f64;
        let rows = field.rings.rows_of(levels);
        for row in rows.start.max(self.marked.0)..rows.end.min(self.marked.1) {
            let blocks = Blocks::of(field, &field.rings.rows[row]);
            let marks = self.marks[row] & field.rings.rows[row].valid;
            for block in (0..BLOCKS).filter(|bit| marks & (1 << bit) != 0) {
                let residuals =
                    self.worths.each_ref().map(|worths| blocks.measure::<false>(worths, block, 0.0).0);
                let of_lane = |lane: usize| of(residuals.map(|residual| residual[lane]));
                worst = (0..LANES).map(of_lane).fold(worst, f64::max);
            }
        }
        worst
    }

    /// Whether steps are to be careful ones.
    pub fn is_restless(&self, rings: &Rings) -> bool {
        self.restless > BOLD_SWEEPS * rings.blocks
    }

    /// Makes steps careful ones at once.
    #[cfg(test)]
    pub fn tire(&mut self, rings: &Rings) {
        self.restless = BOLD_SWEEPS * rings.blocks + 1;
    }

    /// Relaxes until nothing is marked below `limits.frozen_from`, the visits run out, it is stuck, or steps are
    /// no longer to be as careful as these. Returns the visits.
    #[inline(always)]
    pub fn relax<const CAREFUL: bool>(&mut self, field: &Field, limits: &Limits) -> u64 {
        let rings = &field.rings;
        let end = rings.rows_of(0..limits.frozen_from).end;
        let mut visits = 0;
        loop {
            self.tighten(rings);
            if self.at_rest(rings, limits.frozen_from) {
                self.restless = 0;
                return visits;
            }
            if visits >= limits.visits_max || self.is_stuck(rings) || self.is_restless(rings) != CAREFUL {
                return visits;
            }
            let visits_max = limits.visits_max - visits;
            let more = if limits.tolerance > limits.finest {
                self.pass::<CAREFUL, true>(field, limits, end, visits_max)
            } else {
                self.pass::<CAREFUL, false>(field, limits, end, visits_max)
            };
            visits += more;
            self.restless += more;
        }
    }

    /// Finds the first row that bears marks.
    #[inline(always)]
    fn tighten(&mut self, rings: &Rings) {
        let (mut first, end) = self.marked;
        while first < end && self.marks[first] & rings.rows[first].valid == 0 {
            self.marks[first] = 0;
            first += 1;
        }
        self.marked = if first < end { (first, end) } else { NONE };
    }

    /// One pass outwards over what is marked, up to before a row. `ROUGH` if the tolerance is not the finest.
    #[inline(always)]
    fn pass<const CAREFUL: bool, const ROUGH: bool>(
        &mut self,
        field: &Field,
        limits: &Limits,
        end: usize,
        visits_max: u64,
    ) -> u64 {
        let rings = &field.rings;
        let mut visits = 0;
        let mut row = self.marked.0;
        let level = rings.rows[row].level as usize;
        let end = end.min(rings.rows_of(0..level + WINDOW).end);
        let mut left = usize::MAX;
        while row < self.marked.1.min(end) && visits < visits_max {
            let marks = std::mem::take(&mut self.marks[row]) & rings.rows[row].valid;
            if marks != 0 {
                visits += u64::from(marks.count_ones());
                let (moved, rough) = self.visit::<CAREFUL, ROUGH>(field, row, marks, limits);
                if moved.any != 0 {
                    left = left.min(self.touched(field, row, &moved));
                }
                if rough != 0 {
                    self.rough[row] |= rough;
                    self.rough_rows = with(self.rough_rows, row);
                    self.rough_at = self.rough_at.max(limits.tolerance);
                }
            }
            row += 1;
        }
        // What lies beyond has not been looked at; a ring of it may bear marks already.
        self.marked.0 = left.min(row);
        visits
    }

    /// Visits the blocks of a row that are set in `marks`: lanes whose residual is above the tolerance step.
    /// What moved, and the blocks that did not but are short of the finest tolerance.
    #[inline(always)]
    fn visit<const CAREFUL: bool, const ROUGH: bool>(
        &mut self,
        field: &Field,
        row: usize,
        marks: u64,
        limits: &Limits,
    ) -> (Moved, u64) {
        let blocks = Blocks::of(field, &field.rings.rows[row]);
        let mut all = Moved::default();
        let mut rough = 0;
        for worths in &mut self.worths {
            let mut farthest = [0.0; LANES];
            let mut marks = marks;
            while marks != 0 {
                let bit = marks & marks.wrapping_neg();
                let block = marks.trailing_zeros() as usize;
                marks ^= bit;
                let (residual, next) = blocks.measure::<CAREFUL>(worths, block, limits.tolerance);
                blocks.write(worths, block, &next);
                for (farthest, next) in farthest.iter_mut().zip(next) {
                    *farthest = if next.abs() > *farthest { next.abs() } else { *farthest };
                }
                let moved = beyond(&residual, limits.tolerance);
                let if_any = |lanes: u8| if lanes != 0 { bit } else { 0 };
                all.any |= if_any(moved);
                all.first |= if_any(moved & 1);
                all.last |= if_any(moved >> (LANES - 1));
                if ROUGH {
                    rough |= if_any(beyond(&residual, limits.finest));
                }
            }
            // Nobody reads a row while it is visited, itself included.
            if beyond(&farthest, field.magnitude) != 0 {
                blocks.clamp(worths, field.magnitude);
            }
        }
        (all, rough & !all.any)
    }

    /// Marks what reads the lanes that moved, and their blocks; brings their mirrors up to date. The first row
    /// that may be marked now.
    #[inline(always)]
    fn touched(&mut self, field: &Field, row: usize, moved: &Moved) -> usize {
        let Row { before, after, ring, column, mirrored, mirrored_first, rims, .. } = field.rings.rows[row];
        for worths in &mut self.worths {
            for (from, to) in rims {
                worths[to as usize] = worths[from as usize];
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
        let has_moved = moved.any & mirrored | moved.first & mirrored_first;
        if has_moved != 0 { first.min(self.mirror(field, ring as usize)) } else { first }
    }

    /// Brings the mirrors of a ring's nodes up to date, and marks who reads those that change; the first row
    /// of these.
    #[inline(always)]
    fn mirror(&mut self, field: &Field, ring: usize) -> usize {
        let mut first = usize::MAX;
        for mirror in field.rings.mirrors(ring) {
            let mut changes = false;
            for worths in &mut self.worths {
                changes |= worths[mirror.to] != worths[mirror.from];
                worths[mirror.to] = worths[mirror.from];
            }
            // Whether it does is anybody's guess, so there is no branch to guess at.
            let (row, bit) = mirror.reader;
            self.marks[row] |= u64::from(changes) << bit;
            self.marked.1 = self.marked.1.max(row + 1);
            first = if changes { first.min(row) } else { first };
        }
        first
    }
}

/// Blocks of a row in which lanes moved, a bit each: any lane, the first, the last.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::online::rings::{grids, read_by};
    use crate::specimen::{DISCOUNT, Draw, HARD};
    use crate::{Hop, Kind, Leaving, Rules, Site};

    const LOSS: f64 = -900.0;

    /// Flat worlds around goals of all kinds, and the goals.
    fn worlds() -> impl Iterator<Item = (usize, World)> {
        grids().flat_map(|(width, height, goal)| {
            [Leaving::Stays, Leaving::Loses].map(|leaving| {
                let rules = Rules { discount: DISCOUNT, loss: LOSS, leaving, soils: vec![HARD] };
                let mut world = World::new(width, height, rules).expect("a world in range");
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
        let mut draw = Draw(1);
        for (goal, world) in worlds() {
            let field = Field::new(&world);
            let rings = &field.rings;
            let mut relaxation = Relaxation::<1>::default();
            field.worths(&world, &vec![0.0; world.nodes()], &mut relaxation.worths[0]);
            relaxation.clear(rings);
            let stays = world.rules().leaving == Leaving::Stays;
            for step in 0..world.nodes().min(500) {
                let any = (draw.uniform() * world.nodes() as f64) as usize;
                let node = if world.nodes() <= 500 { step } else { any };
                let Some(seat) = rings.seat(node).filter(|_| node != goal) else { continue };
                relaxation.marks.fill(0);
                relaxation.marked = NONE;
                relaxation.worths[0][seat.place] = 1.0 + step as f64;
                relaxation.touch(&field, seat);
                let beside = Hop::ALL.into_iter().filter_map(|hop| world.neighbour(node, hop));
                for reader in beside.chain([node]).filter(|reader| *reader != goal) {
                    let seat = rings.seat(reader).expect("a seat");
                    let row = rings.at(seat.ring).row(seat.block / BLOCKS);
                    let is_marked =
                        relaxation.marks[row] & rings.rows[row].valid & 1 << (seat.block % BLOCKS);
                    let within = (relaxation.marked.0..relaxation.marked.1).contains(&row);
                    assert!(is_marked != 0 && within, "{reader} beside {node}, around {goal}");
                    for (hop, place) in read_by(rings, reader) {
                        let is_worth = |node: usize| match rings.seat(node) {
                            Some(seat) => relaxation.worths[0][seat.place],
                            None => 0.0,
                        };
                        let expected = match world.neighbour(reader, hop) {
                            Some(to) => is_worth(to),
                            None if stays => is_worth(reader),
                            None => LOSS,
                        };
                        let worth = relaxation.worths[0][place];
                        assert_eq!(worth, expected, "{hop:?} of {reader} beside {node}, around {goal}");
                    }
                }
            }
        }
    }

    /// P-ENCLOSED.
    #[test]
    fn a_level_that_is_raised_is_read_as_such_from_everywhere() {
        for (goal, world) in worlds().filter(|(_, world)| world.nodes() < 10_000) {
            let field = Field::new(&world);
            let mut relaxation = Relaxation::<2>::default();
            for worths in &mut relaxation.worths {
                field.worths(&world, &vec![0.0; world.nodes()], worths);
            }
            for level in (0..field.rings.levels).step_by(3) {
                relaxation.raise_level(&field, level, [level as f64, -1.0]);
            }
            let raised = |node: usize| field.rings.level(node).filter(|level| level % 3 == 0 && node != goal);
            for node in (0..world.nodes()).filter(|&node| node != goal) {
                for (hop, place) in read_by(&field.rings, node) {
                    let expected = match world.neighbour(node, hop) {
                        None if world.rules().leaving == Leaving::Loses => [LOSS; 2],
                        to => raised(to.unwrap_or(node)).map_or([0.0; 2], |level| [level as f64, -1.0]),
                    };
                    let worths = relaxation.worths.each_ref().map(|worths| worths[place]);
                    assert_eq!(worths, expected, "{hop:?} of {node}, around {goal}");
                }
            }
        }
    }
}
