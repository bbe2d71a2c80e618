//! What the world has of the nodes of some chunks, brought together so that kernels read whole chunks.
//!
//! A diagonal's nodes lie in as many rows of the world, and are taken one by one, for several chunks before the
//! first of them is read: what is written number by number waits in the processor before it can be read as a chunk.

use crate::World;
use crate::skew::{Block, Blocks, LANES};
use crate::world::Class;

/// Chunks that are gathered together.
const CHUNKS: usize = 8;

/// Some chunks' nodes.
#[derive(Clone, Debug)]
pub(crate) struct Gathered {
    blocks: [Block; CHUNKS],
    payoffs: [[f64; LANES]; CHUNKS],
    slopes: [[[f64; LANES]; 2]; CHUNKS],
    classes: [[Class; LANES]; CHUNKS],
}

/// A chunk's nodes. The lanes beyond its last are lost, whatever their other numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nodes<'a> {
    /// Where they lie.
    pub block: Block,
    /// Payoffs of landing on them.
    pub payoffs: &'a [f64; LANES],
    /// Slopes towards the east and the north.
    pub slopes: &'a [[f64; LANES]; 2],
    /// Soils and kinds.
    pub classes: &'a [Class; LANES],
}

impl Gathered {
    /// Nothing yet.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            blocks: [Block::default(); CHUNKS],
            payoffs: [[0.0; LANES]; CHUNKS],
            slopes: [[[0.0; LANES]; 2]; CHUNKS],
            classes: [[Class::LOST; LANES]; CHUNKS],
        }
    }

    /// Gathers the next chunks, in place of those before; how many, 0 when there are none left.
    #[inline(always)]
    pub fn next(&mut self, blocks: &mut Blocks<'_>, world: &World) -> usize {
        let nodes = world.nodes();
        let ((payoffs, classes), [east, north]) = (world.payoffs(), world.slopes());
        // One check for each node then does for all.
        let (payoffs, classes) = (&payoffs[..nodes], &classes[..nodes]);
        let (east, north) = (&east[..nodes], &north[..nodes]);
        let mut chunks = 0;
        while chunks < CHUNKS {
            let Some(block) = blocks.next() else { break };
            let [into_east, into_north] = &mut self.slopes[chunks];
            let mut node = block.node;
            for lane in 0..block.lanes {
                self.payoffs[chunks][lane] = payoffs[node];
                into_east[lane] = east[node];
                into_north[lane] = north[node];
                self.classes[chunks][lane] = classes[node];
                node = node.wrapping_add_signed(block.stride);
            }
            self.classes[chunks][block.lanes..].fill(Class::LOST);
            self.blocks[chunks] = block;
            chunks += 1;
        }
        chunks
    }

    /// One of the chunks gathered last.
    #[inline(always)]
    pub fn nodes(&self, chunk: usize) -> Nodes<'_> {
        Nodes {
            block: self.blocks[chunk],
            payoffs: &self.payoffs[chunk],
            slopes: &self.slopes[chunk],
            classes: &self.classes[chunk],
        }
    }
}
