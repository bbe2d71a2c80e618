//! Two threads in one wave: the second makes the wave's later sweeps, a few diagonals behind the first.
//!
//! A sweep reads what the sweep before it left on the next diagonal, and nothing further out. So the second
//! thread finds just what it would find if the first one's sweeps had been made before its own, as long as the first
//! is far enough ahead, and the numbers are the same bit for bit.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Numbers that two threads share, by the rule of [`Progress`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shared<'a>(&'a [Cell<f32>]);

// SAFETY: the cells are touched by two threads at most, the leader and the follower of one wave, and never the same
// cell by both without a release and an acquire of `Progress` between. To update a diagonal takes reading and writing
// entries of its own and of the diagonals beside it, with paddings and halo, and laying out the rim of the next, whose
// halo lies beside that; whole chunks that overhang reach one diagonal further. So who is at diagonal n touches
// nothing beyond n - 3 and n + 3, and the follower waits until the leader has finished the eighth diagonal after its
// own.
unsafe impl Send for Shared<'_> {}

impl<'a> Shared<'a> {
    /// Numbers to be shared until the wave is over.
    pub fn new(numbers: &'a mut [f32]) -> Self {
        Self(Cell::from_mut(numbers).as_slice_of_cells())
    }

    /// The numbers, in the thread that has them.
    #[inline(always)]
    pub fn cells(self) -> &'a [Cell<f32>] {
        self.0
    }
}

/// How many diagonals the leader's last sweep has finished.
#[derive(Debug, Default)]
pub(crate) struct Progress(AtomicUsize);

/// How far the follower stays behind, in diagonals.
const BEHIND: usize = 8;
/// Looks at the progress before the processor is left to others.
const LOOKS: u32 = 1_000;

/// The part that a thread has in a wave.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part<'a> {
    /// All of it.
    Whole,
    /// Its first sweeps.
    Leader(&'a Progress),
    /// Its last sweeps.
    Follower(&'a Progress),
}

impl Part<'_> {
    /// Waits until diagonal `line` of `lines` may be begun.
    #[inline(always)]
    pub fn begin(self, line: usize, lines: usize) {
        let Self::Follower(Progress(finished)) = self else { return };
        let need = lines.min(line + BEHIND + 1);
        let mut looks = 0;
        while finished.load(Ordering::Acquire) < need {
            looks += 1;
            if looks < LOOKS {
                std::hint::spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
    }

    /// Tells that so many diagonals have had this part's last sweep.
    #[inline(always)]
    pub fn finish(self, lines: usize) {
        if let Self::Leader(Progress(finished)) = self {
            finished.store(lines, Ordering::Release);
        }
    }
}
