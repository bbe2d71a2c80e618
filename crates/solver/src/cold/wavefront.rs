//! The order in which diagonals are visited: several sweeps move over the grid together, as one wavefront.
//!
//! Each sweep of a wavefront follows the one before at a distance of two diagonals: at step t the first updates
//! diagonal t, the second t − 2, the third t − 4. A diagonal's neighbours are the diagonals beside it, so none of
//! these updates reads what another writes, and the result is that of sweeps made one after the other. But their
//! arithmetic overlaps, and all they touch is in cache.

use std::ops::Range;

/// Several sweeps over all diagonals, two diagonals apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wavefront {
    /// At least 1.
    pub sweeps: usize,
    /// Whether it runs towards the goal.
    pub backwards: bool,
}

impl Wavefront {
    /// Steps from the first update to the last.
    #[inline(always)]
    pub fn steps(self, diagonals: usize) -> usize {
        diagonals + 2 * (self.sweeps - 1)
    }

    /// The sweeps that update a diagonal at a step.
    #[inline(always)]
    pub fn at(self, diagonals: usize, step: usize) -> Range<usize> {
        let passed = (step + 1).saturating_sub(diagonals).div_ceil(2);
        passed..self.sweeps.min(step / 2 + 1)
    }

    /// The diagonal that a sweep of [`Self::at`] updates at a step.
    #[inline(always)]
    pub fn diagonal(self, diagonals: usize, step: usize, sweep: usize) -> usize {
        let index = step - 2 * sweep;
        if self.backwards { diagonals - 1 - index } else { index }
    }
}

/// The largest number of a chunk, at least 0.
pub(crate) fn largest(lanes: &[f32]) -> f32 {
    lanes.iter().copied().fold(0.0, f32::max)
}
