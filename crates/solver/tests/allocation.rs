//! Repeated solves allocate nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

use solver::specimen::Specimen;
use solver::{Effort, Solver};

/// The system's allocator, counting.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// The only test of its file: another one's allocations would be counted too.
#[test]
fn a_second_solve_of_a_world_of_the_same_size_allocates_nothing() {
    let worlds = [Specimen::trap(40, 1), Specimen::plain(40, 2), Specimen::trap(40, 3)]
        .map(|specimen| specimen.world().unwrap());
    let mut solver = Solver::new();
    // A trap comes first, so that the planes of the Krylov method are there as well.
    solver.solve(&worlds[0], &Effort::default());
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    for world in &worlds {
        solver.solve(world, &Effort::default());
    }
    assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0);
}
