//! The order in which diagonals are visited: a window that moves outwards over them.
//!
//! A sweep from the goal outwards carries news of the goal the whole way, but not what flows back: hops
//! that slip outwards see the values of the sweep before, and with slips of 5 % over a horizon of 100 hops
//! a smooth error shrinks only by .05 γ / (1 − .95 γ) = 0.83 a sweep. A window of `behind` + `stride`
//! diagonals, moved by `stride`, visits each diagonal `1 + behind / stride` times before leaving it behind,
//! with what flowed back in between taken up: about half the updates for the same residual, all of them in
//! cache.

use std::ops::Range;

/// A window over diagonals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    behind: usize,
    stride: usize,
}

impl Default for Window {
    fn default() -> Self {
        Self { behind: 16, stride: 4 }
    }
}

impl Window {
    /// Visits to each diagonal in a pass.
    pub fn visits(self) -> u64 {
        (1 + self.behind / self.stride) as u64
    }

    /// One pass outwards over `diagonals`, window by window.
    pub fn pass(self, diagonals: Range<usize>, mut visit: impl FnMut(Diagonals)) {
        let Range { start, end } = diagonals;
        for top in (start + self.stride..end + self.behind + self.stride).step_by(self.stride) {
            let bottom = top.saturating_sub(self.behind + self.stride).max(start);
            if bottom < end {
                let leaves = top.saturating_sub(self.behind);
                visit(Diagonals { range: [bottom, top.min(end)], back: false, leaves });
            }
        }
    }
}

/// Diagonals to visit one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Diagonals {
    range: [usize; 2],
    back: bool,
    /// Only the changes of diagonals below this one count: the window leaves them behind.
    pub leaves: usize,
}

impl Diagonals {
    /// All of `diagonals`, outwards or back, all of their changes counting.
    pub fn all(diagonals: Range<usize>, back: bool) -> Self {
        Self { range: [diagonals.start, diagonals.end], back, leaves: usize::MAX }
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.range[1] - self.range[0]
    }

    /// The diagonal visited as the `index`-th.
    #[inline(always)]
    pub fn at(&self, index: usize) -> usize {
        if self.back { self.range[1] - 1 - index } else { self.range[0] + index }
    }
}

/// The largest of the lanes.
pub(crate) fn largest(lanes: &[f32]) -> f32 {
    lanes.iter().copied().fold(0.0, f32::max)
}
