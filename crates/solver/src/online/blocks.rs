//! The blocks of a row, and what their equations read.

use super::field::Field;
use super::kernel::{Around, Ground, Lanes, backup};
use super::rings::{BLOCKS, LANES, Row};

/// Places of a row.
const PLACES: usize = BLOCKS * LANES;

/// The blocks of one row of the layout, counted from 0. A row has room for [`BLOCKS`], whether its ring has them or
/// not: that a block lies in it need not be checked block by block.
#[derive(Clone, Copy)]
pub(super) struct Blocks<'a> {
    /// Place of the first, and of those beside it: inwards along v, outwards along u.
    place: usize,
    inwards: usize,
    outwards: usize,
    grounds: &'a [Ground; BLOCKS],
    /// Which of the field's patterns of soils each has.
    patterns: &'a [u32; BLOCKS],
    field: &'a Field,
}

impl<'a> Blocks<'a> {
    #[inline(always)]
    pub fn of(field: &'a Field, row: &Row) -> Self {
        let block = row.place / LANES;
        Self {
            place: row.place,
            inwards: row.inwards - 1,
            outwards: row.outwards,
            grounds: chunk(&field.grounds, block),
            patterns: chunk(&field.patterns_of, block),
            field,
        }
    }

    /// Residuals of a block in one field of worths, and the worths after its steps: see [`backup`].
    #[inline(always)]
    pub fn measure<const CAREFUL: bool>(
        &self,
        worths: &[f64],
        block: usize,
        tolerance: f64,
    ) -> (Lanes, Lanes) {
        let block = block % BLOCKS;
        let place = block * LANES;
        let here: &[f64; PLACES] = chunk(worths, self.place);
        let inwards: &[f64; PLACES + 1] = chunk(worths, self.inwards);
        let outwards: &[f64; PLACES + 1] = chunk(worths, self.outwards);
        let around = Around {
            here: chunk(here, place),
            in_v: chunk(inwards, place),
            in_u: chunk(inwards, place + 1),
            out_u: chunk(outwards, place),
            out_v: chunk(outwards, place + 1),
        };
        let soils = &self.field.patterns.soils()[self.patterns[block] as usize];
        backup::<CAREFUL>(soils, &self.grounds[block], &around, tolerance)
    }

    /// Writes a block's worths.
    #[inline(always)]
    pub fn write(&self, worths: &mut [f64], block: usize, next: &Lanes) {
        let here: &mut [f64; PLACES] =
            worths[self.place..].first_chunk_mut().expect("a row has room for all its blocks");
        here[block % BLOCKS * LANES..][..LANES].copy_from_slice(next);
    }

    /// Sees to it that no worth of the row exceeds a magnitude: seldom needed, and kept out of the way.
    #[cold]
    #[inline(never)]
    pub fn clamp(self, worths: &mut [f64], magnitude: f64) {
        for worth in &mut worths[self.place..self.place + PLACES] {
            if *worth > magnitude {
                *worth = magnitude;
            } else if *worth < -magnitude {
                *worth = -magnitude;
            }
        }
    }
}

/// So many of a stream, from `at` on.
#[inline(always)]
fn chunk<T, const N: usize>(stream: &[T], at: usize) -> &[T; N] {
    stream[at..].first_chunk().expect("a row has room for all its blocks")
}
