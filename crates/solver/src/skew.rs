//! The skewed layout: nodes sorted by diagonals, so that a diagonal is one contiguous run.
//!
//! With i and j counted from the corner of the grid nearest the goal, node (i, j) lies on diagonal i + j.
//! Its neighbours lie on the diagonals before and after, never on its own: a Gauss–Seidel sweep, diagonal
//! after diagonal, updates a whole diagonal at once in vector lanes, with the very result of one node
//! after the other, and news of the goal crosses the grid in one sweep. Around the grid runs a halo of
//! one node, and each diagonal is padded to whole chunks of [`LANES`].

use std::cell::Cell;

use crate::World;

/// Lanes of a chunk.
pub(crate) const LANES: usize = 16;

/// Nodes of a diagonal that is so short that a chunk of its own keeps it apart from the next: what overhangs
/// would otherwise wait for the next one's update, which a processor does not take out of the chunk it is writing.
const SHORT: usize = 4 * LANES;

/// Entries of a diagonal that are gathered together.
const STRIP: usize = 8 * LANES;

/// Where each node lies in a plane of the layout.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skew {
    pub width: usize,
    pub height: usize,
    /// Whether i counts from the last column, and j from the last row.
    pub flip: [bool; 2],
    /// The diagonals, that of the corner first.
    runs: Vec<Run>,
    /// The steps over the rim of the grid, diagonal by diagonal.
    rim: Vec<Rim>,
    /// Entries of a plane, padding included.
    pub len: usize,
}

/// Where a diagonal lies in a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    first: usize,
    nodes: usize,
    steps: [isize; 4],
    /// Where its steps over the rim begin and end.
    rim: [usize; 2],
    /// Entries up to the end of the furthest chunk of it or of a neighbour; no chunk begins before entry 0.
    reach: usize,
}

impl Run {
    /// Of a diagonal whose first of so many nodes lies at an entry.
    fn new(first: usize, nodes: usize, steps: [isize; 4], rim: [usize; 2]) -> Self {
        let entries = nodes.next_multiple_of(LANES);
        let begin = |step| first.checked_add_signed(step).expect("a plane holds a layout's neighbours");
        let reach = steps.map(begin).into_iter().fold(first, usize::max) + entries;
        Self { first, nodes, steps, rim, reach }
    }

    /// Entry of the first node, a multiple of [`LANES`].
    #[inline(always)]
    pub fn first(&self) -> usize {
        self.first
    }

    /// Nodes.
    #[inline(always)]
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Distances from an entry to its neighbours: at i − 1, j − 1, i + 1, j + 1.
    #[inline(always)]
    pub fn steps(&self) -> [isize; 4] {
        self.steps
    }
}

/// A step over the rim of the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rim {
    /// Entry of the node on the rim.
    pub at: usize,
    /// The halo's entry beyond.
    pub beyond: usize,
    /// Which of [`Run::steps`] leads there.
    pub step: usize,
}

impl Skew {
    /// Becomes the layout for `world`, whose best goal is `goal`; whether entries lie elsewhere than before.
    pub fn fit(&mut self, world: &World, goal: Option<usize>) -> bool {
        let (width, height) = (world.width(), world.height());
        self.flip =
            goal.map_or([false; 2], |goal| [2 * (goal % width) >= width, 2 * (goal / width) >= height]);
        if (self.width, self.height) == (width, height) {
            return false;
        }
        (self.width, self.height) = (width, height);
        let diagonals = width + height - 1;
        self.runs.clear();
        self.runs.reserve(diagonals);
        self.rim.clear();
        self.rim.reserve(2 * (width + height));
        // Node (i, j) lies at the base of its diagonal + i; so does the halo, at −1 and beyond the last.
        let base = |start: usize, i_first: usize| start as isize - i_first as isize;
        let mut before = base(2 * LANES, 0);
        let mut start = 3 * LANES;
        for diagonal in 0..diagonals {
            let (i_first, nodes) = self.span(diagonal);
            let here = base(start, i_first);
            // Before the first lies a halo node, in the padding of the diagonal before; after the last, another.
            let gap = if nodes < SHORT { LANES } else { 0 };
            let next = start + (nodes + 2).next_multiple_of(LANES) + gap;
            let after = base(next, self.span(diagonal + 1).0);
            let steps = [before - here - 1, before - here, after - here + 1, after - here];
            let (last, i_last) = (start + nodes - 1, i_first + nodes - 1);
            let begin = self.rim.len();
            for (at, step, over) in [
                (start, 0, i_first == 0),
                (start, 3, diagonal - i_first + 1 == height),
                (last, 1, i_last == diagonal),
                (last, 2, i_last + 1 == width),
            ] {
                if over {
                    self.rim.push(Rim { at, beyond: at.wrapping_add_signed(steps[step]), step });
                }
            }
            self.runs.push(Run::new(start, nodes, steps, [begin, self.rim.len()]));
            (before, start) = (here, next);
        }
        self.len = start + 3 * LANES;
        true
    }

    /// The i of a diagonal's first node, and its nodes.
    #[inline(always)]
    fn span(&self, diagonal: usize) -> (usize, usize) {
        let first = (diagonal + 1).saturating_sub(self.height);
        (first, (diagonal + 1).min(self.width).saturating_sub(first))
    }

    /// The diagonals, that of the corner first.
    #[inline(always)]
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The steps over the rim of the grid, diagonal by diagonal.
    pub fn rim(&self) -> &[Rim] {
        &self.rim
    }

    /// The steps over the rim from a diagonal.
    #[inline(always)]
    pub fn rim_of(&self, run: &Run) -> &[Rim] {
        &self.rim[run.rim[0]..run.rim[1]]
    }

    /// Lays the diagonals across: j counts from the other side. Entries stay where they are; nodes do not.
    pub fn turn(&mut self) {
        self.flip[1] = !self.flip[1];
    }

    /// The chunks of the layout that hold nodes, in an order in which both the rows of the grid that they take
    /// from and the chunks themselves lie near one another: in strips across the diagonals.
    #[inline(always)]
    pub fn blocks(&self) -> Blocks<'_> {
        Blocks { skew: self, strip: 0, diagonal: 0, before: 0 }
    }

    /// The chunk of a diagonal with so many nodes before it.
    #[inline(always)]
    fn block(&self, diagonal: usize, before: usize) -> Block {
        let run = &self.runs[diagonal];
        let i = self.span(diagonal).0 + before;
        let j = diagonal - i;
        let x = if self.flip[0] { self.width - 1 - i } else { i };
        let y = if self.flip[1] { self.height - 1 - j } else { j };
        let (along, down) = (if self.flip[0] { -1 } else { 1 }, if self.flip[1] { 1 } else { -1 });
        Block {
            entry: run.first + before,
            steps: run.steps,
            lanes: (run.nodes - before).min(LANES),
            node: y * self.width + x,
            stride: along + down * self.width as isize,
        }
    }
}

/// A chunk of the layout: where its nodes lie in the world.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Block {
    /// Entry of the first.
    pub entry: usize,
    /// Distances to the neighbours, as [`Run::steps`] has them.
    pub steps: [isize; 4],
    /// Nodes.
    pub lanes: usize,
    /// The world's number of the first.
    pub node: usize,
    /// From one to the next.
    pub stride: isize,
}

/// [`Skew::blocks`], the next of which is this.
#[derive(Clone, Debug)]
pub(crate) struct Blocks<'a> {
    skew: &'a Skew,
    strip: usize,
    diagonal: usize,
    before: usize,
}

impl Iterator for Blocks<'_> {
    type Item = Block;

    #[inline(always)]
    fn next(&mut self) -> Option<Block> {
        let skew = self.skew;
        if self.strip >= skew.width.min(skew.height) {
            return None;
        }
        let block = skew.block(self.diagonal, self.before);
        self.before += LANES;
        if self.before >= skew.runs[self.diagonal].nodes.min(self.strip + STRIP) {
            self.diagonal += 1;
            // Diagonals of more nodes than lie before the strip.
            if self.diagonal + self.strip + 1 >= skew.width + skew.height {
                self.strip += STRIP;
                self.diagonal = self.strip;
            }
            self.before = self.strip;
        }
        Some(block)
    }
}

impl Block {
    /// The world's number of the node in a lane.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> usize {
        self.node.wrapping_add_signed(lane as isize * self.stride)
    }
}

/// What a chunk's nodes have of their own: a constant, and four coefficients, each a chunk. All of it lies
/// together, so that a kernel reads one stream.
pub(crate) const PARTS: usize = 5;

/// Where a part of the chunk at an entry begins in the stream.
#[inline(always)]
pub(crate) fn part(at: usize, part: usize) -> usize {
    at * PARTS + part * LANES
}

/// Where the constant of an entry lies in the stream.
#[inline(always)]
pub(crate) fn own(entry: usize) -> usize {
    part(entry - entry % LANES, 0) + entry % LANES
}

/// Kinds of hop: up and down along i, up and down along j.
pub(crate) const HOPS: usize = 4;

/// Where the shift of an entry lies in their stream, chunk by chunk as well.
#[inline(always)]
pub(crate) fn shift(entry: usize, hop: usize) -> usize {
    (entry - entry % LANES) * HOPS + hop * LANES + entry % LANES
}

/// A number of each lane.
pub(crate) type Lanes = [f32; LANES];

/// A chunk of a plane that is shared.
type Cells = [Cell<f32>; LANES];

/// A diagonal of a plane with its neighbours, all in whole chunks: what overlaps may be read and written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around<'a> {
    low_i: &'a [Cells],
    low_j: &'a [Cells],
    high_i: &'a [Cells],
    high_j: &'a [Cells],
    here: &'a [Cells],
}

impl<'a> Around<'a> {
    /// A diagonal's.
    ///
    /// # Panics
    /// If the plane ends before what the diagonal's update reads.
    #[inline(always)]
    pub fn new(cells: &'a [Cell<f32>], run: &Run) -> Self {
        let Run { first, nodes, steps: [low_i, low_j, high_i, high_j], reach, .. } = *run;
        let chunks = nodes.div_ceil(LANES);
        assert!(reach <= cells.len(), "a plane holds what its diagonals read");
        // SAFETY: a run's chunks and its neighbours' lie between entry 0 and its reach, as `Run::new`, the only
        // place where one is made, saw to; and its reach lies in the plane. A diagonal of up to 16 nodes is a single
        // chunk, and to check each of the five rows again takes an eighth of the time of its update.
        unsafe {
            Self {
                low_i: row(cells, first.wrapping_add_signed(low_i), chunks),
                low_j: row(cells, first.wrapping_add_signed(low_j), chunks),
                high_i: row(cells, first.wrapping_add_signed(high_i), chunks),
                high_j: row(cells, first.wrapping_add_signed(high_j), chunks),
                here: row(cells, first, chunks),
            }
        }
    }

    /// Chunks of the run.
    #[inline(always)]
    pub fn chunks(&self) -> usize {
        self.here.len()
    }

    /// Neighbours at i − 1, j − 1, i + 1, j + 1, and the nodes themselves, of a chunk.
    #[inline(always)]
    pub fn chunk(&self, index: usize) -> [Lanes; 5] {
        let mut chunks = [[0.0; LANES]; 5];
        let rows = [self.low_i, self.low_j, self.high_i, self.high_j, self.here];
        for row in 0..5 {
            let cells = &rows[row][index];
            for lane in 0..LANES {
                chunks[row][lane] = cells[lane].get();
            }
        }
        chunks
    }

    /// Replaces a chunk of the nodes.
    #[inline(always)]
    pub fn set(&self, index: usize, new: &Lanes) {
        for (cell, new) in self.here[index].iter().zip(new) {
            cell.set(*new);
        }
    }
}

/// So many chunks from an entry on.
///
/// # Safety
/// They lie within `cells`.
#[inline(always)]
unsafe fn row(cells: &[Cell<f32>], at: usize, chunks: usize) -> &[Cells] {
    // SAFETY: by the condition above. Chunks are arrays of what the slice is of, for as long and as shared.
    unsafe { std::slice::from_raw_parts(cells.as_ptr().add(at).cast(), chunks) }
}

/// The chunk of a plane at an entry.
#[inline(always)]
pub(crate) fn chunk<T: Copy + Default>(plane: &[T], at: usize) -> [T; LANES] {
    let mut chunk = [T::default(); LANES];
    chunk.copy_from_slice(&plane[at..at + LANES]);
    chunk
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::specimen::Specimen;

    #[test]
    fn every_node_has_a_place_and_every_chunk_lies_in_the_plane() {
        let mut skew = Skew::default();
        let sizes = (1..=40).flat_map(|width| (1..=40).map(move |height| (width, height)));
        for (width, height) in sizes.chain([(1, 700), (700, 1), (90, 170)]) {
            let world = Specimen { width, height, ..Specimen::plain(4, 1) }.world().expect("a sound world");
            for corner in [0, width - 1, (height - 1) * width, height * width - 1] {
                skew.fit(&world, Some(corner));
                assert!(skew.runs.iter().all(|run| run.reach <= skew.len), "{width} x {height}");
                let rim = skew.rim.iter().flat_map(|rim| [rim.at, rim.beyond]);
                assert!(rim.max().is_none_or(|entry| entry < skew.len), "{width} x {height}");
                let mut places: Vec<(usize, usize)> = skew
                    .blocks()
                    .flat_map(|block| (0..block.lanes).map(move |lane| (block.at(lane), block.entry + lane)))
                    .collect();
                places.sort_unstable();
                assert!(places.iter().map(|(node, _)| *node).eq(0..width * height), "{width} x {height}");
                places.sort_unstable_by_key(|(_, entry)| *entry);
                assert!(places.is_sorted_by(|a, b| a.1 < b.1), "{width} x {height}: a place for each");
            }
        }
    }
}
