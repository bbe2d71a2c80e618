//! The order in which diagonals are visited: several sweeps in one wave over them.
//!
//! Each sweep of a wave follows the one before at a distance of two diagonals: at its step t the first updates
//! diagonal t, the second t − 2, the third t − 4. A diagonal's neighbours are the diagonals beside it,
//! so none of these updates reads what another writes, and each finds just what it would find if the sweeps
//! were made one after the other. But their arithmetic overlaps, and all they touch is in cache.

use std::ops::Range;

/// A wave over diagonals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wave {
    /// Sweeps in it.
    pub sweeps: usize,
    /// Whether it runs towards the goal.
    pub back: bool,
}

impl Wave {
    /// Steps that it takes over so many diagonals.
    #[inline(always)]
    pub fn steps(self, diagonals: usize) -> usize {
        diagonals + 2 * (self.sweeps - 1)
    }

    /// The sweeps that are at a diagonal at a step.
    #[inline(always)]
    pub fn at(self, diagonals: usize, step: usize) -> Range<usize> {
        let passed = (step + 1).saturating_sub(diagonals).div_ceil(2);
        passed..self.sweeps.min(step / 2 + 1)
    }

    /// The diagonal that such a sweep updates.
    #[inline(always)]
    pub fn diagonal(self, diagonals: usize, step: usize, sweep: usize) -> usize {
        let index = step - 2 * sweep;
        if self.back { diagonals - 1 - index } else { index }
    }
}

/// The largest of the lanes.
pub(crate) fn largest(lanes: &[f32]) -> f32 {
    lanes.iter().copied().fold(0.0, f32::max)
}
