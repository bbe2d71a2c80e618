//! Where each node lies in memory: on rings around a goal, the nodes of a ring side by side.
//!
//! Round the centre the grid falls into four quadrants, each with one arm of the axes, so that a quarter
//! turn maps each onto the next. Within a quadrant a node has coordinates (u, v), both from 0, growing
//! away from the centre; v's direction is u's turned left. Its ring is k = u + v, one less than the number
//! of hops to the centre. Nodes of one ring are no neighbours: from (u, v) a hop leads inwards to
//! (u − 1, v) and (u, v − 1) on ring k − 1, outwards to (u + 1, v) and (u, v + 1) on ring k + 1. So a ring
//! is worked on many nodes at a time, and from ring to ring news of the centre travels outwards in one
//! sweep.
//!
//! Rings lie in memory by quadrant, then by k, a node at lane v. Where a ring ends, a place beyond either
//! end mirrors the node that lies there: one of the next quadrant, the centre, or what leaving the grid
//! is worth.

use std::ops::{Range, RangeInclusive};

use crate::Hop;

/// Nodes worked on at a time, and what rings are aligned to.
pub(super) const LANES: usize = 8;

/// Blocks of a row: bits of a word.
pub(super) const BLOCKS: usize = 64;

/// One ring of one quadrant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// Place of lane −[`LANES`]; need not belong to the ring.
    origin: usize,
    /// First and last lane with a node; none if the first is greater.
    first: i32,
    last: i32,
    /// First and last block with a node, or with a lane beside one, counted from the origin.
    blocks: (u32, u32),
    /// Row of the ring's column 0, where it is or would be.
    rows: usize,
}

impl Ring {
    /// Place of a block.
    #[inline(always)]
    pub fn place(&self, block: usize) -> usize {
        self.origin + block * LANES
    }

    /// The row of a column. The rings beside this one have rows for all columns that its nodes' neighbours lie
    /// in.
    pub fn row(&self, column: usize) -> usize {
        self.rows.wrapping_add(column)
    }

    /// The columns that it has rows for: those of its blocks, and where blocks of the rings beside it may lie that
    /// begin or end a block farther.
    fn columns(&self) -> RangeInclusive<usize> {
        self.blocks.0.saturating_sub(1) as usize / BLOCKS..=(self.blocks.1 + 1) as usize / BLOCKS
    }

    /// Which bits of a column's row stand for a block of the ring.
    fn valid(&self, column: usize) -> u64 {
        let there = |bit: &usize| {
            (self.blocks.0 as usize..=self.blocks.1 as usize).contains(&(BLOCKS * column + bit))
        };
        (0..BLOCKS).filter(there).fold(0, |mask, bit| mask | 1 << bit)
    }

    /// The places of its nodes.
    pub fn places(&self) -> Range<usize> {
        let place = |lane: i32| self.origin + (lane + LANES as i32) as usize;
        place(self.first)..place(self.last + 1)
    }

    /// The blocks that hold nodes.
    pub fn blocks(&self) -> RangeInclusive<usize> {
        let block = |lane: i32| (lane + LANES as i32) as usize / LANES;
        block(self.first)..=block(self.last)
    }
}

/// [`BLOCKS`] blocks of a ring side by side. Rows are numbered from ring to ring outwards; those of one ring
/// number, whatever their quadrant, are neighbours. The rows of one *column* hold the blocks of the same numbers
/// on rings after one another. Rows without blocks of nodes, such as ring −1's, are there to be written to, and
/// lead nowhere but to themselves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Place of its first block, and of that block on the rings inwards and outwards.
    pub place: usize,
    pub inwards: usize,
    pub outwards: usize,
    /// The blocks that there are, a bit each.
    pub valid: u64,
    /// Those with a node that has a mirror, in their first lane or in another.
    pub mirrored_first: u64,
    pub mirrored: u64,
    /// The rows of its column on the rings inwards and outwards.
    pub before: u32,
    pub after: u32,
    /// Which of the ring's blocks it holds: those from 64 `column` on.
    pub column: u32,
    /// Index of the ring, and its number, 0 for ring −1.
    pub ring: u32,
    pub level: u32,
}

/// A place that repeats a node's worth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mirror {
    /// The node's place.
    pub from: usize,
    /// The place that repeats it.
    pub to: usize,
    /// Row, and bit in it, of the block that reads it.
    pub reader: (usize, usize),
    /// Whether the mirror stands for leaving the grid.
    pub rim: bool,
}

/// One quadrant: nodes with u < `across` and v < `along`.
#[derive(Clone, Copy, Debug, Default)]
struct Quadrant {
    across: i32,
    along: i32,
    /// Index of ring −1, which has but a mirror.
    rings: usize,
}

/// The layout.
#[derive(Clone, Debug)]
pub(super) struct Rings {
    width: usize,
    centre: (i32, i32),
    quadrants: [Quadrant; 4],
    rings: Vec<Ring>,
    /// Mirrors of each ring's nodes, and where they begin.
    mirrors: Vec<Mirror>,
    mirrors_from: Vec<u32>,
    /// Places in all.
    pub places: usize,
    /// Rows in order, and the first of each ring number from −1 on.
    pub rows: Vec<Row>,
    rows_from: Vec<usize>,
    /// Rings around the centre.
    pub levels: usize,
    /// Blocks that there are.
    pub blocks: u64,
}

/// What a place of the layout holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seat {
    /// Index of the ring.
    pub ring: usize,
    /// The block in it.
    pub block: usize,
    /// The place.
    pub place: usize,
}

impl Rings {
    /// The layout of a grid around `centre`, a node.
    pub fn new(width: usize, height: usize, centre: usize) -> Self {
        let (x, y) = ((centre % width) as i32, (centre / width) as i32);
        let (east, west) = (width as i32 - 1 - x, x);
        let (north, south) = (height as i32 - 1 - y, y);
        let sides = [(east, north), (north, west), (west, south), (south, east)];
        let mut layout = Self {
            width,
            centre: (x, y),
            quadrants: Default::default(),
            rings: Vec::new(),
            mirrors: Vec::new(),
            mirrors_from: Vec::new(),
            places: 0,
            rows: Vec::new(),
            rows_from: Vec::new(),
            levels: 0,
            blocks: 0,
        };
        // Room before the first ring: its neighbours are read, whatever they hold.
        let margin = (width.max(height) / LANES + 4) * LANES;
        layout.places = margin;
        for (quadrant, (across, beside)) in sides.into_iter().enumerate() {
            let along = beside + 1;
            layout.quadrants[quadrant] = Quadrant { across, along, rings: layout.rings.len() };
            if across == 0 {
                continue;
            }
            for k in -1..across + along {
                layout.push_ring(k, across, along);
            }
            layout.levels = layout.levels.max((across + along - 1) as usize);
        }
        // And behind the last, for all the blocks of a row.
        layout.places += BLOCKS * LANES + margin;
        layout.number();
        layout.link();
        layout
    }

    fn push_ring(&mut self, k: i32, across: i32, along: i32) {
        let (first, last) = ((k - across + 1).max(0), k.min(along - 1));
        let lanes = LANES as i32;
        let block = |lane: i32| ((lane + lanes) / lanes) as u32;
        let blocks = (block(first - 1), block(last + 1));
        self.rings.push(Ring {
            origin: self.places - blocks.0 as usize * LANES,
            first,
            last: if k > across + along - 2 { first - 1 } else { last },
            blocks,
            rows: 0,
        });
        self.places += (blocks.1 - blocks.0 + 1) as usize * LANES;
    }

    /// Numbers the rows.
    fn number(&mut self) {
        let ring_at = |quadrant: &Quadrant, k: usize| {
            let &Quadrant { across, along, rings } = quadrant;
            (across > 0 && k as i32 <= across + along).then(|| rings + k)
        };
        for k in 0..self.levels + 2 {
            self.rows_from.push(self.rows.len());
            for ring in self.quadrants.iter().filter_map(|quadrant| ring_at(quadrant, k)) {
                let at = self.rings[ring];
                self.rings[ring].rows = self.rows.len().wrapping_sub(*at.columns().start());
                for column in at.columns() {
                    let place = at.origin + BLOCKS * column * LANES;
                    let row = self.rows.len() as u32;
                    self.rows.push(Row {
                        place,
                        inwards: place,
                        outwards: place,
                        valid: if k == 0 || at.first > at.last { 0 } else { at.valid(column) },
                        mirrored_first: 0,
                        mirrored: 0,
                        before: row,
                        after: row,
                        ring: ring as u32,
                        level: (k as u32).saturating_sub(1),
                        column: column as u32,
                    });
                }
            }
        }
        self.rows_from.push(self.rows.len());
        for row in self.rows.iter_mut().filter(|row| row.valid != 0) {
            self.blocks += u64::from(row.valid.count_ones());
            let (ring, column) = (row.ring as usize, row.column as usize);
            let (before, after) = (&self.rings[ring - 1], &self.rings[ring + 1]);
            (row.inwards, row.outwards) = (before.place(BLOCKS * column), after.place(BLOCKS * column));
            (row.before, row.after) = (before.row(column) as u32, after.row(column) as u32);
        }
    }

    /// Finds the mirrors of each ring's nodes.
    fn link(&mut self) {
        for quadrant in 0..4 {
            let Quadrant { across, along, rings } = self.quadrants[quadrant];
            if across == 0 {
                continue;
            }
            for k in -1..across + along {
                let ring = rings + (k + 1) as usize;
                self.mirrors_from.push(self.mirrors.len() as u32);
                let Ring { first, last, .. } = self.rings[ring];
                if first > last {
                    continue;
                }
                let seat = |u: i32, v: i32| self.seat_at(quadrant, u, v);
                let mut found = Vec::new();
                let mut mirror = |(u, v): (i32, i32), to: Seat, reader: Seat, rim: bool| {
                    let from = seat(u, v).place;
                    let row = self.rings[reader.ring].row(reader.block / BLOCKS);
                    let reader = (row, reader.block % BLOCKS);
                    found.push(Mirror { from, to: to.place, reader, rim });
                };
                let (next, before) = ((quadrant + 1) % 4, (quadrant + 3) % 4);
                if first == 0 {
                    // v = 0: seen from the quadrant before, or at the rim if there is none.
                    if self.quadrants[before].across > 0 {
                        let to = self.seat_at(before, -1, k + 1);
                        mirror((k, 0), to, self.seat_at(before, 0, k + 1), false);
                    } else {
                        mirror((k, 0), seat(k, -1), seat(k, 0), true);
                    }
                }
                if last == k && k > 0 && self.quadrants[next].across > 0 {
                    // u = 0: seen from the quadrant after.
                    let to = self.seat_at(next, k - 1, -1);
                    mirror((0, k), to, self.seat_at(next, k - 1, 0), false);
                }
                if k - first == across - 1 {
                    mirror((across - 1, first), seat(across, first), seat(across - 1, first), true);
                }
                if last == along - 1 {
                    mirror((k - last, last), seat(k - last, along), seat(k - last, last), true);
                }
                for mirror in &found {
                    let lane = mirror.from - self.rings[ring].origin;
                    let block = lane / LANES;
                    let row = &mut self.rows[self.rings[ring].row(block / BLOCKS)];
                    let mirrored =
                        if lane.is_multiple_of(LANES) { &mut row.mirrored_first } else { &mut row.mirrored };
                    *mirrored |= 1 << (block % BLOCKS);
                }
                self.mirrors.append(&mut found);
            }
        }
        self.mirrors_from.push(self.mirrors.len() as u32);
    }

    fn seat_at(&self, quadrant: usize, u: i32, v: i32) -> Seat {
        let ring = self.quadrants[quadrant].rings + (u + v + 1) as usize;
        let lane = (v + LANES as i32) as usize;
        Seat { ring, block: lane / LANES, place: self.rings[ring].origin + lane }
    }

    /// Where a node lies; `None` for the centre, which has a mirror in each quadrant and no seat.
    pub fn seat(&self, node: usize) -> Option<Seat> {
        let (quadrant, u, v) = self.coordinates(node)?;
        Some(self.seat_at(quadrant, u, v))
    }

    /// The ring number of a node; `None` for the centre.
    pub fn level(&self, node: usize) -> Option<usize> {
        self.coordinates(node).map(|(_, u, v)| (u + v) as usize)
    }

    /// The quadrant of a node; `None` for the centre.
    pub fn quadrant(&self, node: usize) -> Option<usize> {
        self.coordinates(node).map(|(quadrant, _, _)| quadrant)
    }

    fn coordinates(&self, node: usize) -> Option<(usize, i32, i32)> {
        let (dx, dy) =
            ((node % self.width) as i32 - self.centre.0, (node / self.width) as i32 - self.centre.1);
        match (dx, dy) {
            (0, 0) => None,
            _ if dx > 0 && dy >= 0 => Some((0, dx - 1, dy)),
            _ if dy > 0 && dx <= 0 => Some((1, dy - 1, -dx)),
            _ if dx < 0 && dy <= 0 => Some((2, -dx - 1, -dy)),
            _ => Some((3, -dy - 1, dx)),
        }
    }

    /// The node of a quadrant's coordinates.
    fn node_at(&self, quadrant: usize, u: i32, v: i32) -> usize {
        let (dx, dy) = match quadrant {
            0 => (u + 1, v),
            1 => (-v, u + 1),
            2 => (-u - 1, -v),
            _ => (v, -u - 1),
        };
        ((self.centre.1 + dy) as usize) * self.width + (self.centre.0 + dx) as usize
    }

    /// The quadrants that have nodes.
    pub fn quadrants(&self) -> impl Iterator<Item = usize> + '_ {
        (0..4).filter(|&quadrant| self.quadrants[quadrant].across > 0)
    }

    /// The towards-u and towards-v hops of a quadrant.
    pub fn axes(quadrant: usize) -> (Hop, Hop) {
        let u = [Hop::East, Hop::North, Hop::West, Hop::South][quadrant];
        (u, u.left())
    }

    /// Index of the ring at `level` of a quadrant, if it has nodes.
    pub fn ring(&self, quadrant: usize, level: usize) -> Option<usize> {
        let Quadrant { across, along, rings } = self.quadrants[quadrant];
        (across > 0 && (level as i32) < across + along - 1).then(|| rings + level + 1)
    }

    /// The nodes of a ring: node and place.
    pub fn nodes(&self, quadrant: usize, level: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let ring = self.ring(quadrant, level).map(|ring| self.rings[ring]);
        ring.into_iter().flat_map(move |ring| {
            (ring.first..=ring.last).map(move |v| {
                let place = ring.origin + (v + LANES as i32) as usize;
                (self.node_at(quadrant, level as i32 - v, v), place)
            })
        })
    }

    /// The rows of some levels.
    pub fn rows_of(&self, levels: Range<usize>) -> Range<usize> {
        let from = |level: usize| self.rows_from[level.min(self.levels) + 1];
        from(levels.start)..from(levels.end)
    }

    /// One ring, by its index.
    #[inline(always)]
    pub fn at(&self, ring: usize) -> &Ring {
        &self.rings[ring]
    }

    /// The mirrors of a ring's nodes.
    #[inline(always)]
    pub fn mirrors(&self, ring: usize) -> &[Mirror] {
        &self.mirrors[self.mirrors_from[ring] as usize..self.mirrors_from[ring + 1] as usize]
    }

    /// The places that mirror the centre.
    pub fn centres(&self) -> impl Iterator<Item = usize> + '_ {
        self.quadrants().map(|quadrant| self.seat_at(quadrant, -1, 0).place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_but_the_centre_has_a_seat_of_its_own_and_is_found_there() {
        for (width, height) in [(1, 1), (1, 7), (9, 1), (5, 6), (23, 40)] {
            for centre in 0..width * height {
                let rings = Rings::new(width, height, centre);
                let mut taken = vec![false; rings.places];
                let mut nodes = 0;
                for quadrant in rings.quadrants() {
                    for level in 0..rings.levels {
                        for (node, place) in rings.nodes(quadrant, level) {
                            let seat = rings.seat(node).expect("not the centre");
                            assert_eq!((seat.place, rings.level(node)), (place, Some(level)));
                            assert_eq!(rings.at(seat.ring).place(seat.block), place / LANES * LANES);
                            assert!(!std::mem::replace(&mut taken[place], true));
                            nodes += 1;
                        }
                    }
                }
                assert_eq!((nodes, rings.seat(centre)), (width * height - 1, None));
                for mirror in &rings.mirrors {
                    assert!(taken[mirror.from] && !std::mem::replace(&mut taken[mirror.to], true));
                }
                for centre in rings.centres() {
                    assert!(!taken[centre]);
                }
            }
        }
    }
}
