//! Repeated solves allocate nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use solver::fixtures::Fixture;
use solver::{Effort, Solver};

/// The system's allocator, counting for each thread: the test harness allocates on one of its own.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is ending has no count any more.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
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

#[test]
fn a_second_solve_of_a_world_of_the_same_size_allocates_nothing() {
    let worlds = [Fixture::trap(40, 1), Fixture::plain(40, 2), Fixture::trap(40, 3)]
        .map(|fixture| fixture.world().unwrap());
    let mut solver = Solver::new();
    // A trap comes first, so that the planes of the Krylov method are there as well.
    solver.solve(&worlds[0], &Effort::default());
    let before = ALLOCATIONS.get();
    for world in &worlds {
        solver.solve(world, &Effort::default());
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
}
