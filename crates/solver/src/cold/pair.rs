//! Two threads in one wavefront: the follower makes the later sweeps, a few diagonals behind the leader.
//!
//! A sweep reads what the sweep before it left on the next diagonal, and nothing further out. So as long as the leader
//! is far enough ahead, the follower reads what it would read if the leader's sweeps had been completed before, and
//! the numbers are the same bit for bit.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Numbers that two threads share, kept apart by [`LeaderProgress`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shared<'a>(&'a [Cell<f32>]);

// SAFETY: the cells are touched by two threads at most, the leader and the follower of one wavefront, and never the same
// cell by both without a release and an acquire of `LeaderProgress` between. To update a diagonal takes reading and writing
// entries of its own and of the diagonals beside it, with padding and halo, and filling the halo of the next, which
// lies beside that; whole chunks that overhang reach one diagonal further. So a thread at diagonal n touches
// nothing beyond n - 3 and n + 3, and the follower waits until the leader has finished the eighth diagonal after its
// own.
unsafe impl Send for Shared<'_> {}

impl<'a> Shared<'a> {
    /// Shares `numbers` until the wavefront is over.
    pub fn new(numbers: &'a mut [f32]) -> Self {
        Self(Cell::from_mut(numbers).as_slice_of_cells())
    }

    /// The numbers, for one of the two threads.
    #[inline(always)]
    pub fn cells(self) -> &'a [Cell<f32>] {
        self.0
    }
}

/// How many diagonals the leader's last sweep has finished.
#[derive(Debug, Default)]
pub(crate) struct LeaderProgress(AtomicUsize);

/// Diagonals that the follower stays behind.
const BEHIND: usize = 8;
/// Reads of the progress in a busy loop before the thread yields.
const SPINS_MAX: u32 = 1_000;

/// Which sweeps of a wavefront a thread makes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ThreadRole<'a> {
    /// All sweeps, in the only thread.
    Alone,
    /// The first half, reporting its progress.
    Leader(&'a LeaderProgress),
    /// The rest, behind the leader.
    Follower(&'a LeaderProgress),
}

impl ThreadRole<'_> {
    /// Waits until the thread may begin diagonal `diagonal` of `diagonals`.
    #[inline(always)]
    pub fn begin(self, diagonal: usize, diagonals: usize) {
        let Self::Follower(LeaderProgress(finished)) = self else { return };
        let need = diagonals.min(diagonal + BEHIND + 1);
        let mut spins = 0;
        while finished.load(Ordering::Acquire) < need {
            spins += 1;
            if spins < SPINS_MAX {
                std::hint::spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
    }

    /// Publishes how many diagonals have had the leader's last sweep.
    #[inline(always)]
    pub fn finish(self, diagonals: usize) {
        if let Self::Leader(LeaderProgress(finished)) = self {
            finished.store(diagonals, Ordering::Release);
        }
    }
}
