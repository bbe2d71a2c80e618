//! The skewed layout: nodes sorted by diagonals, so that a diagonal is one contiguous run.
//!
//! With i and j counted from the corner of the grid nearest the goal, node (i, j) lies on diagonal i + j.
//! Its neighbours lie on the diagonals before and after, never on its own: a Gauss–Seidel sweep, diagonal
//! after diagonal, updates a whole diagonal at once in vector lanes, with the very result of one node
//! after the other, and news of the goal crosses the grid in one sweep. Around the grid runs a halo of
//! one node, and each diagonal is padded to whole chunks of [`LANES`].

use std::ops::Range;

use crate::survey::PANEL;
use crate::{Kind, World};

/// Lanes of a chunk.
pub(crate) const LANES: usize = 16;

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
    /// Becomes the layout for `world`; whether entries lie elsewhere than before.
    pub fn fit(&mut self, world: &World) -> bool {
        let (width, height) = (world.width(), world.height());
        let goal = (0..world.nodes())
            .filter(|&node| world.kind(node) == Kind::Goal)
            .max_by(|&a, &b| world.payoff(a).total_cmp(&world.payoff(b)));
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

    /// Entries of the nodes in `columns` of row y, in the order of the columns.
    pub fn entries(&self, columns: Range<usize>, y: usize) -> impl Iterator<Item = usize> + '_ {
        let j = 1 + if self.flip[1] { self.height - 1 - y } else { y };
        // i counts up with x, or down.
        let (first, down) =
            if self.flip[0] { (self.width - columns.start, true) } else { (1 + columns.start, false) };
        columns.enumerate().map(move |(k, _)| {
            let i = if down { first - k } else { first + k };
            self.base[i + j] + i
        })
    }

    /// Calls `row` for each row of each panel of columns: entries of one panel stay in the nearest cache
    /// from row to row.
    pub fn visit(&self, mut row: impl FnMut(Range<usize>, usize)) {
        for start in (0..self.width).step_by(PANEL) {
            for y in 0..self.height {
                row(start..self.width.min(start + PANEL), y);
            }
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

    /// Distances from an entry of `diagonal` to its neighbours: at i − 1, j − 1, i + 1, j + 1.
    #[inline(always)]
    pub fn steps(&self, diagonal: usize) -> [isize; 4] {
        let here = self.base[diagonal] as isize;
        let before = self.base[diagonal - 1] as isize - here;
        let after = self.base[diagonal + 1] as isize - here;
        [before - 1, before, after + 1, after]
    }
}

/// What a chunk's nodes have of their own: a constant, and four coefficients. All of it lies together, so a
/// kernel reads one stream, and a chunk that is filled in node by node stays in the nearest cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Ground(pub [[f32; LANES]; 5]);

impl Ground {
    pub const NONE: Self = Self([[0.0; LANES]; 5]);
}

/// The chunk of a plane at an entry.
#[inline(always)]
pub(crate) fn chunk(plane: &[f32], at: usize) -> [f32; LANES] {
    let mut chunk = [0.0; LANES];
    chunk.copy_from_slice(&plane[at..at + LANES]);
    chunk
}
