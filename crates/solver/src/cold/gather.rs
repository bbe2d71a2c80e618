//! The world's numbers for some chunks, gathered so that kernels read whole chunks.
//!
//! Each node of a diagonal lies in a different row of the world, so its numbers are copied one by one. Several chunks
//! are gathered before the first is read, because a processor cannot read a chunk soon after it was written number by
//! number.

use super::skew::{Chunk, Chunks};
use crate::GridWorld;
use crate::grid_world::Class;
use crate::simd::SINGLE_LANES as LANES;

/// Chunks that are gathered together.
const CHUNKS: usize = 8;

/// The nodes of up to [`CHUNKS`] chunks.
#[derive(Clone, Debug)]
pub(crate) struct Gathered {
    chunks: [Chunk; CHUNKS],
    payoffs: [[f64; LANES]; CHUNKS],
    slopes: [[[f64; LANES]; 2]; CHUNKS],
    classes: [[Class; LANES]; CHUNKS],
}

/// The nodes of a chunk. In lanes without a node the class says lost, and the other numbers mean nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nodes<'a> {
    /// Their entries and indices.
    pub chunk: Chunk,
    /// Payoffs r of landing on them.
    pub payoffs: &'a [f64; LANES],
    /// Slopes towards the east and the north, in slope limits.
    pub slopes: &'a [[f64; LANES]; 2],
    /// Their soils and kinds.
    pub classes: &'a [Class; LANES],
}

impl Gathered {
    /// Holds no chunk yet.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            chunks: [Chunk::default(); CHUNKS],
            payoffs: [[0.0; LANES]; CHUNKS],
            slopes: [[[0.0; LANES]; 2]; CHUNKS],
            classes: [[Class::LOST; LANES]; CHUNKS],
        }
    }

    /// Gathers the next chunks over the previous ones and returns how many, 0 at the end.
    #[inline(always)]
    pub fn next(&mut self, remaining: &mut Chunks<'_>, world: &GridWorld) -> usize {
        let nodes = world.nodes();
        let ((payoffs, classes), [east, north]) = (world.payoffs(), world.slopes());
        // Equal lengths, so that one bounds check per node suffices.
        let (payoffs, classes) = (&payoffs[..nodes], &classes[..nodes]);
        let (east, north) = (&east[..nodes], &north[..nodes]);
        let mut chunks = 0;
        while chunks < CHUNKS {
            let Some(chunk) = remaining.next() else { break };
            let [into_east, into_north] = &mut self.slopes[chunks];
            let mut node = chunk.node;
            for lane in 0..chunk.lanes {
                self.payoffs[chunks][lane] = payoffs[node];
                into_east[lane] = east[node];
                into_north[lane] = north[node];
                self.classes[chunks][lane] = classes[node];
                node = node.wrapping_add_signed(chunk.stride);
            }
            self.classes[chunks][chunk.lanes..].fill(Class::LOST);
            self.chunks[chunks] = chunk;
            chunks += 1;
        }
        chunks
    }

    /// The nodes of one of the chunks gathered last.
    #[inline(always)]
    pub fn nodes(&self, index: usize) -> Nodes<'_> {
        Nodes {
            chunk: self.chunks[index],
            payoffs: &self.payoffs[index],
            slopes: &self.slopes[index],
            classes: &self.classes[index],
        }
    }
}
