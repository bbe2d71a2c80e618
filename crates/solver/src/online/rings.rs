//! Where each node lies in memory: on rings around a goal, the nodes of a ring side by side.
//!
//! **Sectors.** Around the centre the grid has four sectors, each with one arm of the axes, so that a quarter turn maps
//! each onto the next. Within a sector a node has coordinates (u, v), both from 0, growing away from the centre; v's
//! direction is u's turned left.
//!
//! **Rings.** The ring of a node is k = u + v, one less than the number of hops to the centre. Nodes of one ring are not
//! neighbours: from (u, v) a hop leads inwards to (u − 1, v) and (u, v − 1) on ring k − 1, and outwards to (u + 1, v)
//! and (u, v + 1) on ring k + 1. So many nodes of a ring are updated at a time, and a change at the centre travels
//! outwards, from ring to ring, in one sweep.
//!
//! **Thin strips.** If the centre lies at most [`THIN`] nodes from a side of the grid, sectors beyond it would be strips
//! of short rings that cost as much as long ones. There the sectors on this side contain the strip as well: two share
//! the grid, or in a corner one has all of it, the centre included. Their u or v begins at the grid's side, and rings
//! run straight across the strip. Some ways from the strip to the centre then lead outwards. But whatever the sectors,
//! neighbours are on adjacent rings, and the relaxation relies on nothing else.
//!
//! **Levels.** Rings of one level are updated together. The level is k, shifted from sector to sector so that
//! neighbours in two sectors lie on adjacent levels as well.
//!
//! **Memory.** An *entry* is the index of a node's number in a field. Rings are stored by sector, then by k, a node at
//! lane v, in *blocks* of [`LANES`] nodes. 64 blocks of a ring form a *row*. Beyond either end of a ring lies a *ghost*:
//! a copy of the node that lies there, in the next sector or at the centre, or what leaving the grid is worth.

use std::ops::{Range, RangeInclusive};

use crate::simd::DOUBLE_LANES as LANES;
use crate::{Hop, Leaving};

/// Blocks of a row: the bits of a word.
pub(super) const BLOCKS: usize = 64;

/// A centre at most this far from a side has no sectors beyond. On 200 x 200 nodes strips of up to ten gain something,
/// and wider ones lose where a change has to travel far outwards; with this few, the small worlds of tests have layouts
/// of every kind.
const THIN: i32 = 3;

/// One ring of one sector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// Entry of lane −[`LANES`]; need not belong to the ring.
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
    /// First entry of a block.
    #[inline(always)]
    pub fn entry(&self, block: usize) -> usize {
        self.origin + block * LANES
    }

    /// The row of a column. Adjacent rings have rows for all columns in which neighbours of this ring's nodes lie.
    pub fn row(&self, column: usize) -> usize {
        self.rows.wrapping_add(column)
    }

    /// The columns that it has rows for: those of its blocks, and those of adjacent rings' blocks, which may begin or end
    /// one block further.
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

    /// The entries of its nodes.
    pub fn entries(&self) -> Range<usize> {
        let entry = |lane: i32| self.origin + (lane + LANES as i32) as usize;
        entry(self.first)..entry(self.last + 1)
    }

    /// The blocks that hold nodes.
    pub fn blocks(&self) -> RangeInclusive<usize> {
        let block = |lane: i32| (lane + LANES as i32) as usize / LANES;
        block(self.first)..=block(self.last)
    }
}

/// [`BLOCKS`] blocks of a ring side by side. Rows are numbered by level, outwards; those of one level, whatever their
/// sector, have consecutive numbers. The rows of one *column* hold the blocks of the same numbers on successive rings.
/// Rows without blocks of nodes, such as ring −1's, only absorb writes, and are their own neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// First entry of its first block, and of the same block on the rings inwards and outwards.
    pub entry: usize,
    pub inwards: usize,
    pub outwards: usize,
    /// The blocks of the ring that it holds, one bit each.
    pub valid: u64,
    /// The blocks whose first lane, or another lane, has a ghost that is not among `border_ghosts`.
    pub ghosted_first: u64,
    pub ghosted: u64,
    /// Ghosts outside the grid that copy a node of the row for that node itself, from and to: the first two of at most
    /// four. An unused one copies an entry to itself.
    pub border_ghosts: [(u32, u32); 2],
    /// The rows of its column on the rings inwards and outwards.
    pub before: u32,
    pub after: u32,
    /// Its first block is the ring's block 64 · `column`.
    pub column: u32,
    /// Index of the ring, and its level, at least 0.
    pub ring: u32,
    pub level: u32,
}

/// An entry that copies a node's value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ghost {
    /// Entry of the node.
    pub from: usize,
    /// Entry of the copy.
    pub to: usize,
    /// Row, and bit in it, of the block that reads the copy.
    pub reader: (usize, usize),
}

/// One sector: a quarter, half, or all of the grid.
#[derive(Clone, Copy, Debug, Default)]
struct Sector {
    /// Nodes along u and along v; none if there is no such sector.
    across: i32,
    along: i32,
    /// The centre is at (below.0 − 1, below.1): how far the sector goes on beyond its axes.
    below: (i32, i32),
    /// Level of its first ring.
    level: usize,
    /// Index of the ring before that, which only has a ghost.
    rings: usize,
}

/// The layout of a grid on rings around a centre.
#[derive(Clone, Debug)]
pub(super) struct Rings {
    width: usize,
    centre: (i32, i32),
    /// The side of the centre, as signs of x and y, that all nodes of the grid count as lying on; 0 if both sides have
    /// sectors of their own.
    sides: (i32, i32),
    sectors: [Sector; 4],
    rings: Vec<Ring>,
    /// Ghosts, ring by ring, and where those of each ring begin.
    ghosts: Vec<Ghost>,
    ghosts_from: Vec<u32>,
    /// Entries outside the grid that hold the loss.
    pub outside: Vec<usize>,
    /// Length of a field.
    pub entries: usize,
    /// Rows in order, and the first of each level from −1 on.
    pub rows: Vec<Row>,
    rows_from: Vec<usize>,
    /// Number of levels.
    pub levels: usize,
    /// Number of blocks with nodes, over all rings.
    pub blocks: u64,
}

/// Where a node lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slot {
    /// Index of the ring.
    pub ring: usize,
    /// The block in it.
    pub block: usize,
    /// Index in a field.
    pub entry: usize,
}

impl Rings {
    /// The layout of a grid around `centre`, a node.
    pub fn new(width: usize, height: usize, centre: usize, leaving: Leaving) -> Self {
        let (x, y) = ((centre % width) as i32, (centre / width) as i32);
        // Nodes beyond the centre to the east, north, west and south.
        let rooms = [width as i32 - 1 - x, height as i32 - 1 - y, x, y];
        let side = |axis: usize| match (rooms[axis], rooms[axis + 2]) {
            (ahead, behind) if ahead.min(behind) > THIN => 0,
            (ahead, behind) if ahead >= behind => 1,
            _ => -1,
        };
        let sides = [side(0), side(1), -side(0), -side(1)];
        let mut layout = Self {
            width,
            centre: (x, y),
            sides: (sides[0], sides[1]),
            sectors: Default::default(),
            rings: Vec::new(),
            ghosts: Vec::new(),
            ghosts_from: Vec::new(),
            outside: Vec::new(),
            entries: 0,
            rows: Vec::new(),
            rows_from: Vec::new(),
            levels: 0,
            blocks: 0,
        };
        for (index, sector) in layout.sectors.iter_mut().enumerate() {
            let (u, v) = (index, (index + 1) % 4);
            if sides[u] < 0 || sides[v] < 0 {
                continue;
            }
            let below = |direction: usize| if sides[direction] == 0 { 0 } else { rooms[(direction + 2) % 4] };
            sector.below = (below(u) + sides[u], below(v));
            sector.across = rooms[u] + sector.below.0;
            sector.along = rooms[v] + 1 + sector.below.1;
        }
        let depth = |sector: &Sector| sector.below.0 + sector.below.1;
        let deepest = layout.sectors.iter().map(depth).max().unwrap_or(0);
        // Room before the first ring, whose neighbours are read although their numbers do not matter.
        let margin = (width.max(height) / LANES + 4) * LANES;
        layout.entries = margin;
        for index in layout.sectors() {
            let Sector { across, along, .. } = layout.sectors[index];
            let level = (deepest - depth(&layout.sectors[index])) as usize;
            (layout.sectors[index].level, layout.sectors[index].rings) = (level, layout.rings.len());
            for k in -1..across + along {
                layout.push_ring(k, across, along);
            }
            layout.levels = layout.levels.max(level + (across + along - 1) as usize);
        }
        // And behind the last, for all the blocks of a row.
        layout.entries += BLOCKS * LANES + margin;
        debug_assert!(u32::try_from(layout.entries).is_ok(), "{} entries", layout.entries);
        layout.number();
        layout.link(leaving);
        layout
    }

    /// Adds ring `k` of a sector.
    fn push_ring(&mut self, k: i32, across: i32, along: i32) {
        let (first, last) = ((k - across + 1).max(0), k.min(along - 1));
        let lanes = LANES as i32;
        let block = |lane: i32| ((lane + lanes) / lanes) as u32;
        let blocks = (block(first - 1), block(last + 1));
        self.rings.push(Ring {
            origin: self.entries - blocks.0 as usize * LANES,
            first,
            last: if k > across + along - 2 { first - 1 } else { last },
            blocks,
            rows: 0,
        });
        self.entries += (blocks.1 - blocks.0 + 1) as usize * LANES;
    }

    /// Numbers the rows by level, and links them with those of adjacent rings.
    fn number(&mut self) {
        let ring_at = |sector: &Sector, k: usize| {
            let k = k.checked_sub(sector.level)?;
            (sector.across > 0 && k as i32 <= sector.across + sector.along).then(|| sector.rings + k)
        };
        for k in 0..self.levels + 2 {
            self.rows_from.push(self.rows.len());
            for ring in self.sectors.iter().filter_map(|sector| ring_at(sector, k)) {
                let at = self.rings[ring];
                self.rings[ring].rows = self.rows.len().wrapping_sub(*at.columns().start());
                for column in at.columns() {
                    let entry = at.origin + BLOCKS * column * LANES;
                    let row = self.rows.len() as u32;
                    self.rows.push(Row {
                        entry,
                        inwards: entry,
                        outwards: entry,
                        valid: if at.first > at.last { 0 } else { at.valid(column) },
                        ghosted_first: 0,
                        ghosted: 0,
                        border_ghosts: [(entry as u32, entry as u32); 2],
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
            (row.inwards, row.outwards) = (before.entry(BLOCKS * column), after.entry(BLOCKS * column));
            (row.before, row.after) = (before.row(column) as u32, after.row(column) as u32);
        }
    }

    /// Finds the ghosts of each ring's nodes.
    fn link(&mut self, leaving: Leaving) {
        let cut = [self.sides.0 == 0, self.sides.1 == 0];
        for sector in self.sectors() {
            let Sector { across, along, below, rings, .. } = self.sectors[sector];
            // Whether what lies before u = 0 and before v = 0 belongs to other sectors; else there is nothing.
            let (other_sector_u, other_sector_v) = (cut[sector % 2], cut[(sector + 1) % 2]);
            for k in -1..across + along {
                let ring = rings + (k + 1) as usize;
                self.ghosts_from.push(self.ghosts.len() as u32);
                let Ring { first, last, .. } = self.rings[ring];
                if first > last {
                    continue;
                }
                let slot = |u: i32, v: i32| self.slot_at(sector, u, v);
                // Who is seen, where, and by whom.
                let mut found = Vec::new();
                if first == 0 && other_sector_v {
                    // v = 0: seen from the sector before.
                    let before = (sector + 3) % 4;
                    let v = k - below.0 + 1 + self.sectors[before].below.1;
                    found.push((slot(k, 0), self.slot_at(before, -1, v), self.slot_at(before, 0, v)));
                } else if first == 0 {
                    found.push((slot(k, 0), slot(k, -1), slot(k, 0)));
                }
                if last == k && other_sector_u {
                    // u = 0: seen from the sector after, but for what only the centre would see.
                    let after = (sector + 1) % 4;
                    let u = k - below.1 - 1 + self.sectors[after].below.0;
                    if u >= 0 {
                        found.push((slot(0, k), self.slot_at(after, u, -1), self.slot_at(after, u, 0)));
                    }
                } else if last == k {
                    found.push((slot(0, k), slot(-1, k), slot(0, k)));
                }
                if k - first == across - 1 {
                    let node = slot(across - 1, first);
                    found.push((node, slot(across, first), node));
                }
                if last == along - 1 {
                    let node = slot(k - last, last);
                    found.push((node, slot(k - last, along), node));
                }
                for (node, to, reader) in found {
                    if node == reader && leaving == Leaving::Loses {
                        self.outside.push(to.entry);
                        continue;
                    }
                    let row_of = |slot: &Slot| self.rings[slot.ring].row(slot.block / BLOCKS);
                    let reader_at = (row_of(&reader), reader.block % BLOCKS);
                    let row = &mut self.rows[row_of(&node)];
                    let free =
                        row.border_ghosts.iter_mut().find(|border| node == reader && border.0 == border.1);
                    if let Some(border) = free {
                        *border = (node.entry as u32, to.entry as u32);
                    } else {
                        // Another's, or a border for which there is no room.
                        let is_first = node.entry.is_multiple_of(LANES);
                        let ghosted = if is_first { &mut row.ghosted_first } else { &mut row.ghosted };
                        *ghosted |= 1 << (node.block % BLOCKS);
                    }
                    self.ghosts.push(Ghost { from: node.entry, to: to.entry, reader: reader_at });
                }
            }
        }
        self.ghosts_from.push(self.ghosts.len() as u32);
    }

    fn slot_at(&self, sector: usize, u: i32, v: i32) -> Slot {
        let ring = self.sectors[sector].rings + (u + v + 1) as usize;
        let lane = (v + LANES as i32) as usize;
        Slot { ring, block: lane / LANES, entry: self.rings[ring].origin + lane }
    }

    /// Where a node lies; `None` for the centre of four sectors, which has a ghost in each and no slot.
    pub fn slot(&self, node: usize) -> Option<Slot> {
        let (sector, u, v) = self.coordinates(node)?;
        Some(self.slot_at(sector, u, v))
    }

    /// The level of a node; `None` where it has no slot.
    pub fn level(&self, node: usize) -> Option<usize> {
        self.coordinates(node).map(|(sector, u, v)| self.sectors[sector].level + (u + v) as usize)
    }

    /// The sector of a node; `None` where it has no slot.
    pub fn sector(&self, node: usize) -> Option<usize> {
        self.coordinates(node).map(|(sector, _, _)| sector)
    }

    /// The sector of a node and its coordinates there; `None` for a centre without a slot.
    fn coordinates(&self, node: usize) -> Option<(usize, i32, i32)> {
        let (dx, dy) =
            ((node % self.width) as i32 - self.centre.0, (node / self.width) as i32 - self.centre.1);
        let lies = |side: i32, offset: i32| if side == 0 { offset } else { side };
        let sector = match (lies(self.sides.0, dx), lies(self.sides.1, dy)) {
            (0, 0) => return None,
            (x, y) if x > 0 && y >= 0 => 0,
            (x, y) if y > 0 && x <= 0 => 1,
            (x, y) if x < 0 && y <= 0 => 2,
            _ => 3,
        };
        let (u, v) = [(dx, dy), (dy, -dx), (-dx, -dy), (-dy, dx)][sector];
        let (below_u, below_v) = self.sectors[sector].below;
        Some((sector, u - 1 + below_u, v + below_v))
    }

    /// The node of a sector's coordinates.
    fn node_at(&self, sector: usize, u: i32, v: i32) -> usize {
        let (below_u, below_v) = self.sectors[sector].below;
        let (u, v) = (u + 1 - below_u, v - below_v);
        let (dx, dy) = [(u, v), (-v, u), (-u, -v), (v, -u)][sector];
        ((self.centre.1 + dy) as usize) * self.width + (self.centre.0 + dx) as usize
    }

    /// The sectors that there are.
    pub fn sectors(&self) -> impl Iterator<Item = usize> + use<> {
        let there = self.sectors.map(|sector| sector.across > 0);
        (0..4).filter(move |&sector| there[sector])
    }

    /// The towards-u and towards-v hops of a sector.
    pub fn axes(sector: usize) -> (Hop, Hop) {
        let u = [Hop::East, Hop::North, Hop::West, Hop::South][sector];
        (u, u.left())
    }

    /// Index of the ring at `level` of a sector, if it has nodes.
    pub fn ring(&self, sector: usize, level: usize) -> Option<usize> {
        let Sector { across, along, level: first, rings, .. } = self.sectors[sector];
        let k = level.checked_sub(first)?;
        (across > 0 && (k as i32) < across + along - 1).then(|| rings + k + 1)
    }

    /// The nodes of a ring: node and entry.
    pub fn nodes(&self, sector: usize, level: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let ring = self.ring(sector, level).map(|ring| self.rings[ring]);
        let k = level as i32 - self.sectors[sector].level as i32;
        ring.into_iter().flat_map(move |ring| {
            (ring.first..=ring.last).map(move |v| {
                let entry = ring.origin + (v + LANES as i32) as usize;
                (self.node_at(sector, k - v, v), entry)
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

    /// The ghosts of a ring's nodes.
    #[inline(always)]
    pub fn ghosts(&self, ring: usize) -> &[Ghost] {
        &self.ghosts[self.ghosts_from[ring] as usize..self.ghosts_from[ring + 1] as usize]
    }

    /// The ghosts of all nodes.
    pub fn all_ghosts(&self) -> &[Ghost] {
        &self.ghosts
    }

    /// The entries that ghost a centre without a slot.
    pub fn centres(&self) -> impl Iterator<Item = usize> + '_ {
        let slotless = self.sides == (0, 0);
        self.sectors().filter(move |_| slotless).map(|sector| self.slot_at(sector, -1, 0).entry)
    }
}

/// The entries that a node's equation reads along each hop.
#[cfg(test)]
pub(super) fn read_by(rings: &Rings, node: usize) -> [(Hop, usize); 4] {
    let slot = rings.slot(node).expect("a slot");
    let row = &rings.rows[rings.at(slot.ring).row(slot.block / BLOCKS)];
    let lane = slot.entry - row.entry;
    let (u, v) = Rings::axes(rings.sector(node).expect("a slot"));
    [
        (u, row.outwards + lane),
        (v, row.outwards + lane + 1),
        (u.left().left(), row.inwards + lane),
        (v.left().left(), row.inwards + lane - 1),
    ]
}

/// Width, height and centre of grids with the centre in a corner, at a side, and inside, of those that have no inside,
/// and of some whose rings have several rows.
#[cfg(test)]
pub(super) fn grids() -> impl Iterator<Item = (usize, usize, usize)> {
    let small = [(1, 1), (1, 7), (9, 1), (5, 6), (12, 8), (19, 20)].into_iter();
    let large = [(600, 9), (9, 600), (530, 540)].into_iter();
    let everywhere = |(width, height)| (0..width * height).map(move |centre| (width, height, centre));
    let here_and_there = |(width, height)| {
        let middle = height / 2 * width + width / 2;
        [0, width / 2, middle - width / 2, middle].map(|centre| (width, height, centre))
    };
    small.flat_map(everywhere).chain(large.flat_map(here_and_there))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The layouts of [`grids`], with either way of leaving.
    fn all_rings() -> impl Iterator<Item = (usize, usize, usize, Leaving, Rings)> {
        grids().flat_map(|(width, height, centre)| {
            [Leaving::Stays, Leaving::Loses]
                .map(|leaving| (width, height, centre, leaving, Rings::new(width, height, centre, leaving)))
        })
    }

    #[test]
    fn every_node_but_the_centre_of_four_sectors_has_a_seat_of_its_own_and_is_found_there() {
        let mut seen = [0; 5];
        for (width, height, centre, _, rings) in all_rings() {
            let mut taken = vec![false; rings.entries];
            let mut nodes = 0;
            for sector in rings.sectors() {
                for level in 0..rings.levels {
                    for (node, entry) in rings.nodes(sector, level) {
                        let slot = rings.slot(node).expect("a slot");
                        let found = (slot.entry, rings.level(node), rings.sector(node));
                        assert_eq!(found, (entry, Some(level), Some(sector)));
                        assert_eq!(rings.at(slot.ring).entry(slot.block), entry / LANES * LANES);
                        assert!(!std::mem::replace(&mut taken[entry], true));
                        nodes += 1;
                    }
                }
            }
            let sectors = rings.sectors().count();
            let has_slot = sectors < 4;
            assert_eq!(
                (nodes, rings.slot(centre).is_some()),
                (width * height - usize::from(!has_slot), has_slot)
            );
            for ghost in &rings.ghosts {
                assert!(taken[ghost.from] && !std::mem::replace(&mut taken[ghost.to], true));
            }
            for entry in rings.centres().chain(rings.outside.iter().copied()) {
                assert!(!std::mem::replace(&mut taken[entry], true));
            }
            seen[sectors] += 1;
        }
        assert!([1, 2, 4].into_iter().all(|sectors| seen[sectors] > 100), "{seen:?}");
    }

    #[test]
    fn around_a_node_lie_its_neighbours_on_the_rings_beside_its_own() {
        const BEYOND: usize = usize::MAX;
        for (width, height, centre, leaving, rings) in all_rings() {
            let mut held = vec![None; rings.entries];
            for node in (0..width * height).filter(|&node| rings.slot(node).is_some()) {
                held[rings.slot(node).expect("a slot").entry] = Some(node);
            }
            rings.ghosts.iter().for_each(|ghost| held[ghost.to] = held[ghost.from]);
            rings.centres().for_each(|entry| held[entry] = Some(centre));
            rings.outside.iter().for_each(|&entry| held[entry] = Some(BEYOND));
            let leaves_to = |node: usize| if leaving == Leaving::Stays { node } else { BEYOND };
            for node in (0..width * height).filter(|&node| rings.slot(node).is_some()) {
                for (hop, entry) in read_by(&rings, node) {
                    let (x, y) = (node % width, node / width);
                    let beside = match hop {
                        Hop::East => (x + 1 < width).then(|| node + 1),
                        Hop::North => (y + 1 < height).then(|| node + width),
                        Hop::West => x.checked_sub(1).map(|_| node - 1),
                        Hop::South => y.checked_sub(1).map(|_| node - width),
                    };
                    // It does not matter what the centre reads.
                    if node != centre {
                        let expected = beside.unwrap_or(leaves_to(node));
                        assert_eq!(held[entry], Some(expected), "{hop:?} of {node}, around {centre}");
                    }
                    if let Some((one, other)) = rings.level(node).zip(beside.and_then(|to| rings.level(to))) {
                        assert_eq!(one.abs_diff(other), 1, "{hop:?} of {node}, around {centre}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_row_knows_of_every_mirror_of_its_nodes() {
        for (width, height, centre, _, rings) in all_rings() {
            for node in 0..width * height {
                let Some(slot) = rings.slot(node) else { continue };
                let row = &rings.rows[rings.at(slot.ring).row(slot.block / BLOCKS)];
                let is_first = slot.entry % LANES == 0;
                let ghosted = if is_first { row.ghosted_first } else { row.ghosted };
                for ghost in rings.ghosts(slot.ring).iter().filter(|ghost| ghost.from == slot.entry) {
                    let border = (ghost.from as u32, ghost.to as u32);
                    let known =
                        row.border_ghosts.contains(&border) || ghosted & (1 << (slot.block % BLOCKS)) != 0;
                    assert!(known, "{node} of {width} x {height} around {centre}");
                }
            }
        }
    }
}
