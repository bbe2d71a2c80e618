//! The blocks of a row, and the entries that their equations read.

use super::kernel::{Lanes, NodeLanes, Stencil, backup};
use super::layout::Layout;
use super::rings::{BLOCKS, Row};
use crate::simd::DOUBLE_LANES as LANES;

/// Entries of a row.
const ENTRIES: usize = BLOCKS * LANES;

/// The blocks of one row, counted from 0. Memory holds [`BLOCKS`] of them even where the ring has fewer, so that bounds
/// are checked once per row.
#[derive(Clone, Copy)]
pub(super) struct Blocks<'a> {
    /// First entry of the row, of its neighbours inwards along v, and outwards along u.
    entry: usize,
    inwards: usize,
    outwards: usize,
    node_lanes: &'a [NodeLanes; BLOCKS],
    /// The number of each block's pattern of soils.
    patterns: &'a [u32; BLOCKS],
    layout: &'a Layout,
}

impl<'a> Blocks<'a> {
    #[inline(always)]
    pub fn of(layout: &'a Layout, row: &Row) -> Self {
        let block = row.entry / LANES;
        Self {
            entry: row.entry,
            inwards: row.inwards - 1,
            outwards: row.outwards,
            node_lanes: chunk(&layout.node_lanes, block),
            patterns: chunk(&layout.patterns_of, block),
            layout,
        }
    }

    /// Residuals of a block in one field, and the values after its steps: see [`backup`].
    #[inline(always)]
    pub fn measure<const SAFEGUARDED: bool>(
        &self,
        afterstates: &[f64],
        block: usize,
        tolerance: f64,
    ) -> (Lanes, Lanes) {
        let block = block % BLOCKS;
        let entry = block * LANES;
        let here: &[f64; ENTRIES] = chunk(afterstates, self.entry);
        let inwards: &[f64; ENTRIES + 1] = chunk(afterstates, self.inwards);
        let outwards: &[f64; ENTRIES + 1] = chunk(afterstates, self.outwards);
        let around = Stencil {
            here: chunk(here, entry),
            in_v: chunk(inwards, entry),
            in_u: chunk(inwards, entry + 1),
            out_u: chunk(outwards, entry),
            out_v: chunk(outwards, entry + 1),
        };
        let soils = &self.layout.patterns.soils()[self.patterns[block] as usize];
        backup::<SAFEGUARDED>(soils, &self.node_lanes[block], &around, tolerance)
    }

    /// Writes a block's values.
    #[inline(always)]
    pub fn write(&self, afterstates: &mut [f64], block: usize, next: &Lanes) {
        let here: &mut [f64; ENTRIES] =
            afterstates[self.entry..].first_chunk_mut().expect("a row has room for all its blocks");
        here[block % BLOCKS * LANES..][..LANES].copy_from_slice(next);
    }

    /// Clamps the row's values to a magnitude. Rarely needed, so kept out of the hot path.
    #[cold]
    #[inline(never)]
    pub fn clamp(self, afterstates: &mut [f64], magnitude: f64) {
        for value in &mut afterstates[self.entry..self.entry + ENTRIES] {
            if *value > magnitude {
                *value = magnitude;
            } else if *value < -magnitude {
                *value = -magnitude;
            }
        }
    }
}

/// `N` items of `stream` from `at` on.
#[inline(always)]
fn chunk<T, const N: usize>(stream: &[T], at: usize) -> &[T; N] {
    stream[at..].first_chunk().expect("a row has room for all its blocks")
}
