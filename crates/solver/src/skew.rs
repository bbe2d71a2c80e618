//! The skewed layout: nodes sorted by diagonals, so that a diagonal is one contiguous run.
//!
//! With i and j counted from the corner of the grid nearest the goal, node (i, j) lies on diagonal i + j.
//! Its neighbours lie on the diagonals before and after, never on its own: a Gauss–Seidel sweep, diagonal
//! after diagonal, updates a whole diagonal at once in vector lanes, with the very result of one node
//! after the other, and news of the goal crosses the grid in one sweep. Around the grid runs a halo of
//! one node, and each diagonal is padded to whole chunks of [`LANES`].

use std::cell::Cell;
use std::ops::Range;

use crate::World;

/// Lanes of a chunk.
pub(crate) const LANES: usize = 16;

/// Which of [`Skew::steps`] the places of [`Skew::rim`] step over the rim by.
const RIM_STEPS: [usize; 4] = [0, 3, 1, 2];

/// Entries of a diagonal that are gathered together.
const STRIP: usize = 8 * LANES;

/// Where each node lies in a plane of the layout.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skew {
    pub width: usize,
    pub height: usize,
    /// Whether i counts from the last column, and j from the last row.
    pub flip: [bool; 2],
    /// Node (i, j) of diagonal d = i + j + 2, the halo being i = −1 and j = −1, lies at `base[d]` + i + 1.
    pub base: Vec<usize>,
    /// Entries of a plane, padding included.
    pub len: usize,
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
        self.base.clear();
        let mut start = 2 * LANES;
        for diagonal in 0..=width + height + 2 {
            // The first interior node of the diagonal stands at a multiple of LANES.
            let first = diagonal.saturating_sub(height).max(1);
            let last = (diagonal.saturating_sub(1)).min(width);
            let nodes = (last + 1).saturating_sub(first);
            self.base.push(start - first);
            // Before the first lies a halo node, in the padding of the diagonal before; after the last, another.
            start += (nodes + 2).next_multiple_of(LANES);
        }
        self.len = start + 2 * LANES;
        true
    }

    /// Lays the diagonals across: j counts from the other side. Entries stay where they are; nodes do not.
    pub fn turn(&mut self) {
        self.flip[1] = !self.flip[1];
    }

    /// The diagonals that hold nodes of the grid.
    pub fn diagonals(&self) -> Range<usize> {
        2..self.width + self.height + 1
    }

    /// Entry of the first node of a diagonal, and nodes on it.
    #[inline(always)]
    pub fn run(&self, diagonal: usize) -> (usize, usize) {
        let first = diagonal.saturating_sub(self.height).max(1);
        let last = (diagonal - 1).min(self.width);
        (self.base[diagonal] + first, last + 1 - first)
    }

    /// The chunks of the layout that hold nodes, in an order in which both the rows of the grid that they take
    /// from and the chunks themselves lie near one another: in strips across the diagonals.
    #[inline(always)]
    pub fn blocks(&self) -> Blocks<'_> {
        Blocks { skew: self, strip: 0, diagonal: 2, before: 0 }
    }

    /// The chunk of a diagonal with so many nodes before it.
    #[inline(always)]
    fn block(&self, diagonal: usize, before: usize) -> Block {
        let (first, nodes) = self.run(diagonal);
        let i = first - self.base[diagonal] + before;
        let j = diagonal - i;
        let x = if self.flip[0] { self.width - i } else { i - 1 };
        let y = if self.flip[1] { self.height - j } else { j - 1 };
        let (along, down) = (if self.flip[0] { -1 } else { 1 }, if self.flip[1] { 1 } else { -1 });
        Block {
            entry: first + before,
            steps: self.steps(diagonal),
            lanes: (nodes - before).min(LANES),
            node: y * self.width + x,
            stride: along + down * self.width as isize,
        }
    }

    /// The four places where a diagonal, from entry `first` to `last`, may touch the rim of the grid: an entry
    /// on it, and the step from there into the halo, or 0 where it does not.
    #[inline(always)]
    pub fn rim(&self, diagonal: usize, first: usize, last: usize, steps: [isize; 4]) -> [(usize, isize); 4] {
        let (i_first, i_last) = (first - self.base[diagonal], last - self.base[diagonal]);
        let [before_i, before_j, after_i, after_j] = steps;
        [
            (first, if i_first == 1 { before_i } else { 0 }),
            (first, if diagonal - i_first == self.height { after_j } else { 0 }),
            (last, if diagonal - i_last == 1 { before_j } else { 0 }),
            (last, if i_last == self.width { after_i } else { 0 }),
        ]
    }

    /// Every step over the rim: an entry on it, the halo's entry beyond, and the index of the step among
    /// [`Skew::steps`].
    pub fn border(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        self.diagonals().flat_map(|diagonal| {
            let (first, nodes) = self.run(diagonal);
            let rim = self.rim(diagonal, first, first + nodes - 1, self.steps(diagonal));
            let over = rim.into_iter().zip(RIM_STEPS).filter(|((_, step), _)| *step != 0);
            over.map(|((at, step), index)| (at, at.wrapping_add_signed(step), index))
        })
    }

    /// Distances from an entry of `diagonal` to its neighbours: at i − 1, j − 1, i + 1, j + 1.
    #[inline(always)]
    pub fn steps(&self, diagonal: usize) -> [isize; 4] {
        let here = self.base[diagonal] as isize;
        let before = self.base[diagonal - 1] as isize - here;
        let after = self.base[diagonal + 1] as isize - here;
        [before - 1, before, after + 1, after]
    }
}

/// A chunk of the layout: where its nodes lie in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    /// Entry of the first.
    pub entry: usize,
    /// Distances to the neighbours, as [`Skew::steps`] has them.
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
        if self.before >= skew.run(self.diagonal).1.min(self.strip + STRIP) {
            self.diagonal += 1;
            // Diagonals of more nodes than lie before the strip.
            if self.diagonal > skew.width + skew.height - self.strip {
                self.strip += STRIP;
                self.diagonal = 2 + self.strip;
            }
            self.before = self.strip;
        }
        Some(block)
    }
}

impl Block {
    /// What `of` has for the block's nodes; in the lanes beyond, what it has for the last.
    ///
    /// # Panics
    /// If `of` does not have all of them.
    #[inline(always)]
    pub fn pick<T: Copy>(&self, of: &[T]) -> [T; LANES] {
        let last = self.lanes - 1;
        let end = self.node.wrapping_add_signed(last as isize * self.stride);
        assert!(self.node < of.len() && end < of.len(), "a block lies within its world");
        let mut picked = [of[end]; LANES];
        if last + 1 == LANES {
            for (lane, picked) in picked.iter_mut().enumerate() {
                // SAFETY: the node lies between the first and the last, both of which are asserted to be in range.
                // A check of each is half of what picking costs.
                *picked = *unsafe { of.get_unchecked(self.at(lane)) };
            }
        } else {
            for (lane, picked) in picked[..last].iter_mut().enumerate() {
                *picked = of[self.at(lane)];
            }
        }
        picked
    }

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

/// A diagonal of a plane with its neighbours, all in whole chunks: what overlaps may be read and written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around<'a> {
    low_i: &'a [Cell<f32>],
    low_j: &'a [Cell<f32>],
    high_i: &'a [Cell<f32>],
    high_j: &'a [Cell<f32>],
    here: &'a [Cell<f32>],
}

impl<'a> Around<'a> {
    /// The run of `nodes` nodes from entry `first` on, `steps` away from its neighbours.
    #[inline(always)]
    pub fn new(plane: &'a mut [f32], first: usize, nodes: usize, steps: [isize; 4]) -> Self {
        Self::of(Cell::from_mut(plane).as_slice_of_cells(), first, nodes, steps)
    }

    /// The same in a plane that is shared.
    #[inline(always)]
    pub fn of(cells: &'a [Cell<f32>], first: usize, nodes: usize, steps: [isize; 4]) -> Self {
        let len = nodes.next_multiple_of(LANES);
        let [low_i, low_j, high_i, high_j] = steps.map(|step| first.wrapping_add_signed(step));
        Self {
            low_i: &cells[low_i..low_i + len],
            low_j: &cells[low_j..low_j + len],
            high_i: &cells[high_i..high_i + len],
            high_j: &cells[high_j..high_j + len],
            here: &cells[first..first + len],
        }
    }

    /// Entries of the run, padding included.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.here.len()
    }

    /// Chunks of the run.
    #[inline(always)]
    pub fn chunks(&self) -> usize {
        self.here.len() / LANES
    }

    /// Neighbours at i − 1, j − 1, i + 1, j + 1, and the nodes themselves, of a chunk.
    #[inline(always)]
    pub fn chunk(&self, index: usize) -> [Lanes; 5] {
        let mut chunks = [[0.0; LANES]; 5];
        let rows = [self.low_i, self.low_j, self.high_i, self.high_j, self.here];
        for row in 0..5 {
            let cells = &rows[row][index * LANES..][..LANES];
            for lane in 0..LANES {
                chunks[row][lane] = cells[lane].get();
            }
        }
        chunks
    }

    /// Replaces a chunk of the nodes.
    #[inline(always)]
    pub fn set(&self, index: usize, new: &Lanes) {
        let cells = &self.here[index * LANES..][..LANES];
        for lane in 0..LANES {
            cells[lane].set(new[lane]);
        }
    }
}

/// The chunk of a plane at an entry.
#[inline(always)]
pub(crate) fn chunk<T: Copy + Default>(plane: &[T], at: usize) -> [T; LANES] {
    let mut chunk = [T::default(); LANES];
    chunk.copy_from_slice(&plane[at..at + LANES]);
    chunk
}
