//! The skewed layout: nodes sorted by diagonals, so that a diagonal is one contiguous run.
//!
//! With i and j counted from the corner of the grid nearest the goal, node (i, j) lies on diagonal i + j.
//! Its neighbours lie on the diagonals before and after, never on its own. So a Gauss–Seidel sweep, diagonal
//! after diagonal, updates a whole diagonal at once in vector lanes, with the same result as one node after the
//! other, and a change at the goal crosses the grid in one sweep. A halo of one node surrounds the grid, and each
//! diagonal is padded to whole chunks of [`LANES`].

use std::cell::Cell;

use crate::GridWorld;
use crate::simd::SINGLE_LANES as LANES;

/// Diagonals with fewer nodes are kept apart from the next by an empty chunk. Otherwise reading a chunk that overhangs
/// the next diagonal would wait until that diagonal's update is written, since a processor does not forward part of a
/// store.
const SHORT: usize = 4 * LANES;

/// Entries of a diagonal that [`Skew::chunks`] visits before it goes on to the next diagonal.
const STRIP: usize = 8 * LANES;

/// Where each node lies in a plane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skew {
    pub width: usize,
    pub height: usize,
    /// Whether i counts from the last column, and j from the last row.
    pub flip: [bool; 2],
    /// The diagonals, that of the corner first.
    diagonals: Vec<Diagonal>,
    /// The steps over the border of the grid, diagonal by diagonal.
    border: Vec<BorderStep>,
    /// Entries of a plane, padding included.
    pub len: usize,
}

/// Where a diagonal lies in a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Diagonal {
    first: usize,
    nodes: usize,
    steps: [isize; 4],
    /// Its range in [`Skew::border`].
    border: [usize; 2],
    /// End of the furthest chunk of this diagonal or a neighbour; no chunk begins before entry 0.
    reach: usize,
}

impl Diagonal {
    /// A diagonal of `nodes` nodes, the first of which lies at entry `first`.
    fn new(first: usize, nodes: usize, steps: [isize; 4], border: [usize; 2]) -> Self {
        let entries = nodes.next_multiple_of(LANES);
        let begin = |step| first.checked_add_signed(step).expect("a plane holds a layout's neighbours");
        let reach = steps.map(begin).into_iter().fold(first, usize::max) + entries;
        Self { first, nodes, steps, border, reach }
    }

    /// Entry of the first node, a multiple of [`LANES`].
    #[inline(always)]
    pub fn first(&self) -> usize {
        self.first
    }

    /// Nodes on it, padding excluded.
    #[inline(always)]
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Offsets from an entry to its neighbours at i − 1, j − 1, i + 1, j + 1.
    #[inline(always)]
    pub fn steps(&self) -> [isize; 4] {
        self.steps
    }
}

/// A step from a node on the border into the halo.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BorderStep {
    /// Entry of the node on the border.
    pub at: usize,
    /// Entry of the halo that the step leads to.
    pub beyond: usize,
    /// Which of [`Diagonal::steps`] leads there.
    pub step: usize,
}

impl Skew {
    /// Becomes the layout for `world`, whose best goal is `goal`. True if the size changed, so that planes need a reset.
    pub fn fit(&mut self, world: &GridWorld, goal: Option<usize>) -> bool {
        let (width, height) = (world.width(), world.height());
        self.flip =
            goal.map_or([false; 2], |goal| [2 * (goal % width) >= width, 2 * (goal / width) >= height]);
        if (self.width, self.height) == (width, height) {
            return false;
        }
        (self.width, self.height) = (width, height);
        let diagonals = width + height - 1;
        self.diagonals.clear();
        self.diagonals.reserve(diagonals);
        self.border.clear();
        self.border.reserve(2 * (width + height));
        // Node (i, j) lies at the base of its diagonal + i; so does the halo, at −1 and beyond the last.
        let base = |start: usize, i_first: usize| start as isize - i_first as isize;
        let mut before = base(2 * LANES, 0);
        let mut start = 3 * LANES;
        for diagonal in 0..diagonals {
            let (i_first, nodes) = self.span(diagonal);
            let here = base(start, i_first);
            // Before the first node lies a halo node, in the padding of the diagonal before; after the last, another.
            let gap = if nodes < SHORT { LANES } else { 0 };
            let next = start + (nodes + 2).next_multiple_of(LANES) + gap;
            let after = base(next, self.span(diagonal + 1).0);
            let steps = [before - here - 1, before - here, after - here + 1, after - here];
            let (last, i_last) = (start + nodes - 1, i_first + nodes - 1);
            let begin = self.border.len();
            for (at, step, over) in [
                (start, 0, i_first == 0),
                (start, 3, diagonal - i_first + 1 == height),
                (last, 1, i_last == diagonal),
                (last, 2, i_last + 1 == width),
            ] {
                if over {
                    self.border.push(BorderStep { at, beyond: at.wrapping_add_signed(steps[step]), step });
                }
            }
            self.diagonals.push(Diagonal::new(start, nodes, steps, [begin, self.border.len()]));
            (before, start) = (here, next);
        }
        self.len = start + 3 * LANES;
        true
    }

    /// The i of a diagonal's first node, and the number of its nodes.
    #[inline(always)]
    fn span(&self, diagonal: usize) -> (usize, usize) {
        let first = (diagonal + 1).saturating_sub(self.height);
        (first, (diagonal + 1).min(self.width).saturating_sub(first))
    }

    /// The diagonals, that of the corner first.
    #[inline(always)]
    pub fn diagonals(&self) -> &[Diagonal] {
        &self.diagonals
    }

    /// The steps over the border of the grid, diagonal by diagonal.
    pub fn border(&self) -> &[BorderStep] {
        &self.border
    }

    /// The steps over the border from one diagonal.
    #[inline(always)]
    pub fn border_of(&self, diagonal: &Diagonal) -> &[BorderStep] {
        &self.border[diagonal.border[0]..diagonal.border[1]]
    }

    /// Counts j from the other side, so that diagonals run the other way. The entries stay; the nodes in them change.
    pub fn flip_j(&mut self) {
        self.flip[1] = !self.flip[1];
    }

    /// The chunks that hold nodes, in strips across the diagonals: in this order both the chunks and the rows of the
    /// grid that they are gathered from lie near one another.
    #[inline(always)]
    pub fn chunks(&self) -> Chunks<'_> {
        Chunks { skew: self, strip: 0, diagonal: 0, before: 0 }
    }

    /// The chunk of a diagonal that begins after `before` nodes.
    #[inline(always)]
    fn chunk_of(&self, diagonal: usize, before: usize) -> Chunk {
        let run = &self.diagonals[diagonal];
        let i = self.span(diagonal).0 + before;
        let j = diagonal - i;
        let x = if self.flip[0] { self.width - 1 - i } else { i };
        let y = if self.flip[1] { self.height - 1 - j } else { j };
        let (along, down) = (if self.flip[0] { -1 } else { 1 }, if self.flip[1] { 1 } else { -1 });
        Chunk {
            entry: run.first + before,
            steps: run.steps,
            lanes: (run.nodes - before).min(LANES),
            node: y * self.width + x,
            stride: along + down * self.width as isize,
        }
    }
}

/// A chunk of the layout, and where its nodes lie in the world.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Chunk {
    /// Entry of the first node.
    pub entry: usize,
    /// [`Diagonal::steps`] of its diagonal.
    pub steps: [isize; 4],
    /// Lanes with a node, 1 to [`LANES`].
    pub lanes: usize,
    /// The world's index of the first node.
    pub node: usize,
    /// Step from one node's index to the next.
    pub stride: isize,
}

/// The iterator of [`Skew::chunks`]; its fields describe the next chunk.
#[derive(Clone, Debug)]
pub(crate) struct Chunks<'a> {
    skew: &'a Skew,
    strip: usize,
    diagonal: usize,
    before: usize,
}

impl Iterator for Chunks<'_> {
    type Item = Chunk;

    #[inline(always)]
    fn next(&mut self) -> Option<Chunk> {
        let skew = self.skew;
        if self.strip >= skew.width.min(skew.height) {
            return None;
        }
        let block = skew.chunk_of(self.diagonal, self.before);
        self.before += LANES;
        if self.before >= skew.diagonals[self.diagonal].nodes.min(self.strip + STRIP) {
            self.diagonal += 1;
            // Only diagonals with nodes in the strip.
            if self.diagonal + self.strip + 1 >= skew.width + skew.height {
                self.strip += STRIP;
                self.diagonal = self.strip;
            }
            self.before = self.strip;
        }
        Some(block)
    }
}

impl Chunk {
    /// The world's index of the node in a lane.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> usize {
        self.node.wrapping_add_signed(lane as isize * self.stride)
    }
}

/// Parts of a chunk's coefficients: a constant and four factors, a chunk of numbers each. They lie side by side, so that
/// a kernel reads one stream.
pub(crate) const PARTS: usize = 5;

/// Where a part of the chunk at entry `at` begins among the coefficients.
#[inline(always)]
pub(crate) fn part_at(at: usize, part: usize) -> usize {
    at * PARTS + part * LANES
}

/// Where the constant of an entry lies among the coefficients.
#[inline(always)]
pub(crate) fn constant_at(entry: usize) -> usize {
    part_at(entry - entry % LANES, 0) + entry % LANES
}

/// Kinds of hop: up and down along i, up and down along j.
pub(crate) const HOPS: usize = 4;

/// Where the shift of an entry for a kind of hop lies among the shifts, which are stored chunk by chunk as well.
#[inline(always)]
pub(crate) fn shift_at(entry: usize, hop: usize) -> usize {
    (entry - entry % LANES) * HOPS + hop * LANES + entry % LANES
}

/// One number per lane.
pub(crate) type Lanes = [f32; LANES];

/// A chunk of a plane that two threads may share.
type Cells = [Cell<f32>; LANES];

/// A diagonal of a plane and the diagonals of its neighbours, in whole chunks, which may overlap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stencil<'a> {
    low_i: &'a [Cells],
    low_j: &'a [Cells],
    high_i: &'a [Cells],
    high_j: &'a [Cells],
    here: &'a [Cells],
}

impl<'a> Stencil<'a> {
    /// The stencil of one diagonal.
    ///
    /// # Panics
    /// If the plane ends before what the diagonal's update reads.
    #[inline(always)]
    pub fn new(cells: &'a [Cell<f32>], run: &Diagonal) -> Self {
        let Diagonal { first, nodes, steps: [low_i, low_j, high_i, high_j], reach, .. } = *run;
        let chunks = nodes.div_ceil(LANES);
        assert!(reach <= cells.len(), "a plane holds what its diagonals read");
        // SAFETY: the diagonal's chunks and its neighbours' lie between entry 0 and its reach, which `Diagonal::new`
        // ensures, the only place that makes one; and the assertion above keeps its reach in the plane. A diagonal of
        // up to 16 nodes is a single chunk; checking each of the five rows again takes an eighth of its update's time.
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

    /// Chunks of the diagonal.
    #[inline(always)]
    pub fn chunks(&self) -> usize {
        self.here.len()
    }

    /// The numbers of a chunk's neighbours at i − 1, j − 1, i + 1, j + 1, then its own.
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

    /// Overwrites a chunk of the diagonal.
    #[inline(always)]
    pub fn set(&self, index: usize, new: &Lanes) {
        for (cell, new) in self.here[index].iter().zip(new) {
            cell.set(*new);
        }
    }
}

/// `chunks` chunks from entry `at` on.
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
    use crate::fixtures::Fixture;

    #[test]
    fn every_node_has_a_place_and_every_chunk_lies_in_the_plane() {
        let mut skew = Skew::default();
        let sizes = (1..=40).flat_map(|width| (1..=40).map(move |height| (width, height)));
        for (width, height) in sizes.chain([(1, 700), (700, 1), (90, 170)]) {
            let world = Fixture { width, height, ..Fixture::plain(4, 1) }.world().expect("a sound world");
            for corner in [0, width - 1, (height - 1) * width, height * width - 1] {
                skew.fit(&world, Some(corner));
                assert!(
                    skew.diagonals.iter().all(|diagonal| diagonal.reach <= skew.len),
                    "{width} x {height}"
                );
                let border = skew.border.iter().flat_map(|border| [border.at, border.beyond]);
                assert!(border.max().is_none_or(|entry| entry < skew.len), "{width} x {height}");
                let mut places: Vec<(usize, usize)> = skew
                    .chunks()
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
